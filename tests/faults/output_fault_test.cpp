// Writing, and reading back, each kind of output while calls fail.
#include "lode/api/files.h"
#include "tests/faults/fault_scratch.h"
#include "tests/faults/fault_storm.h"
#include "tests/oracles/analytic_fields.h"

namespace lode::test {
namespace {

class fault_output : public FaultTest {
 protected:
  fault_output() {
    surface_.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    surface_.normals.assign(4, {{0, 0, 1}});
    surface_.isovalues.assign(4, 1.5F);
    surface_.triangles = {{0, 1, 2}, {0, 1, 3}};
  }

  /// write(path) makes the file of that name, the same each time.
  static void expect_writes(const std::string& name,
                            const std::function<Result<void>(const std::string&)>& write,
                            const std::string& input = "") {
    SCOPED_TRACE(name);
    const FaultScratch scratch(name);
    const auto written = write(scratch.output());
    ASSERT_TRUE(written) << written.error().message;
    const std::string expected = read_bytes(scratch.output());
    Operation operation;
    operation.files = {scratch.output(), scratch.path("")};  // spools are known by the directory
    if (!input.empty()) operation.files.push_back(input);
    operation.prepare = [&] { scratch.prepare(); };
    operation.run = [&] { return write(scratch.output()); };
    operation.expect_done = [&] { scratch.expect_output(expected); };
    operation.expect_undone = [&](const std::string&) { scratch.expect_untouched(); };
    expect_survives_all(operation);
  }

  Surface surface_;
};

TEST_F(fault_output, of_surfaces_is_whole_or_the_old_one) {
  const SurfaceWriteOptions options{.comment = "made by a test of what happens when calls fail"};
  for (const char* name : {"a.ply", "a.stl", "a.obj", "a.vtp", "a.glb"})
    expect_writes(name, [&](const std::string& path) {
      Progress progress;
      return write_surface(path, surface_, options, progress);
    });
}

TEST_F(fault_output, of_surfaces_in_pieces_is_whole_or_the_old_one) {
  const FaultScratch stored("field.lode");
  {
    const auto source = make_memory_source(oracles::sample(oracles::Field::gaussians40, 17));
    Progress progress;
    const auto dataset = Dataset::build(*source, {}, progress);
    ASSERT_TRUE(dataset && dataset->save(stored.output(), {}, progress));
  }
  // So little memory that vertices and cells wait on the disk.
  const ExtractOptions options{
      .isovalues = {0.3, 0.5}, .max_error = 0.05, .threads = {1}, .memory_limit = 40'000};
  for (const char* name : {"a.ply", "a.stl", "a.vtp"})
    expect_writes(
        name,
        [&](const std::string& path) -> Result<void> {
          Progress progress;
          LODE_TRY(const auto dataset, Dataset::open(stored.output(), {1}));
          LODE_CHECK(extract_to_file(
              dataset, options, path, [](const ExtractReport&) { return SurfaceWriteOptions(); },
              progress));
          return {};
        },
        stored.output());
}

TEST_F(fault_output, of_surfaces_can_be_read_back_or_says_why_not) {
  for (const char* name : {"a.ply", "a.stl", "a.obj", "a.vtp", "a.glb"}) {
    SCOPED_TRACE(name);
    const FaultScratch scratch(name);
    Progress progress;
    ASSERT_TRUE(write_surface(scratch.output(), surface_, {}, progress));
    Result<Surface> surface = Surface();
    Operation operation;
    operation.files = {scratch.output()};
    operation.run = [&]() -> Result<void> {
      surface = read_surface(scratch.output());
      if (!surface) return std::move(surface).error();
      return {};
    };
    operation.expect_done = [&] { EXPECT_EQ(surface->triangles.size(), 2U); };
    expect_survives_all(operation);
  }
}

TEST_F(fault_output, of_meshes_is_whole_or_the_old_one) {
  SimplexMesh mesh;
  mesh.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
  mesh.values = {1, 2, 3, 4};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.errors = {0.5F};
  for (const char* const name : {"a.vtu", "a.vtk", "a.msh", "a.e"})
    expect_writes(name, [&](const std::string& path) {
      Progress progress;
      return write_mesh(path, mesh, {}, progress);
    });
}

TEST_F(fault_output, of_pictures_texts_and_cameras_is_whole_or_the_old_one) {
  const Image image{.width = 2, .height = 2, .pixels = std::vector<Color>(4, Color{1, 2, 3, 255})};
  expect_writes("a.png", [&](const std::string& path) { return write_png(image, path); });
  expect_writes("a.txt", [](const std::string& path) {
    return write_text(path, "some text that is long enough to need memory", Progress());
  });
  Camera camera;
  camera.eye = {{1, 2, 3}};
  expect_writes("a.json", [&](const std::string& path) { return write_camera(camera, path); });
}

TEST_F(fault_output, drawing_ends_in_an_error_or_the_picture) {
  const RenderOptions options{.width = 8, .height = 8, .samples_per_pixel = 1, .threads = {2}};
  const Box3d bounds{{{0, 0, 0}}, {{1, 1, 1}}};
  Progress unhindered;
  const auto expected = render_surface(surface_, bounds, options, unhindered);
  ASSERT_TRUE(expected) << expected.error().message;
  Result<Image> image = Image();
  Operation operation;
  operation.run = [&]() -> Result<void> {
    Progress progress;
    image = render_surface(surface_, bounds, options, progress);
    if (!image) return std::move(image).error();
    return {};
  };
  operation.expect_done = [&] { EXPECT_TRUE(*image == *expected) << "the picture differs"; };
  expect_survives(operation, Fault::memory);
}

TEST_F(fault_output, of_cameras_can_be_read_back_or_says_why_not) {
  const FaultScratch scratch("camera.json");
  Camera camera;
  camera.eye = {{1, 2, 3}};
  ASSERT_TRUE(write_camera(camera, scratch.output()));
  Result<Camera> read = Camera();
  Operation operation;
  operation.files = {scratch.output()};
  operation.run = [&]() -> Result<void> {
    read = read_camera(scratch.output());
    if (!read) return std::move(read).error();
    return {};
  };
  operation.expect_done = [&] { EXPECT_EQ(read->eye, camera.eye); };
  expect_survives_all(operation);
}

}  // namespace
}  // namespace lode::test
