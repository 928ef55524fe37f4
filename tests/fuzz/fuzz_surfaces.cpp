// Foreign surfaces and camera files: the input is the file. What is read can be written, and read
// again as the same.
#include <cmath>

#include "lode/io/surface_file.h"
#include "lode/render/camera_file.h"
#include "tests/fuzz/fuzz_files.h"

namespace lode::fuzz {
namespace {

void check_surface(const Surface& surface) {
  const std::size_t n = surface.positions.size();
  expect(surface.triangles.empty() || surface.lines.empty(), "triangles or lines");
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t v : triangle) expect(v < n, "corners exist");
  for (const auto& line : surface.lines)
    for (const std::uint32_t v : line) expect(v < n, "ends exist");
  expect(surface.normals.empty() || surface.normals.size() == n, "a normal each");
  expect(surface.isovalues.empty() || surface.isovalues.size() == n, "an isovalue each");
  expect(surface.values.empty() || surface.values.size() == n, "a value each");
  expect(surface.origins.empty() || surface.origins.size() == n, "an origin each");
  const std::size_t n_cells = surface.triangles.size() + surface.lines.size();
  expect(surface.errors.empty() || surface.errors.size() == n_cells, "an error a cell");
}

void read_file(const std::string& name, Input input) {
  const std::string path = fuzz_directory().write(name, input);
  const auto surface = io::read_surface(path);
  if (!surface) {
    expect(surface.error().message.find(path) != std::string::npos, "an error names the file");
    return;
  }
  check_surface(*surface);
  const std::string copy = fuzz_directory().path("copy-" + name);
  Progress progress;
  if (!io::write_surface(copy, *surface, {}, progress)) return;  // STL cannot hold everything
  const auto again = io::read_surface(copy);
  // What is empty in one format need not be a file in another's eyes.
  if (again) expect(again->triangles.size() == surface->triangles.size(), "as many triangles");
}

}  // namespace

void run_ply(Input input) { read_file("a.ply", input); }
void run_vtp(Input input) { read_file("a.vtp", input); }
void run_stl(Input input) { read_file("a.stl", input); }
void run_obj(Input input) { read_file("a.obj", input); }
void run_glb(Input input) { read_file("a.glb", input); }

void run_camera(Input input) {
  const std::string path = fuzz_directory().write("camera.json", input);
  const std::string copy = fuzz_directory().path("copy.json");
  if (const auto camera = read_camera(path)) {
    expect(write_camera(*camera, copy).has_value(), "a camera that was read can be written");
    const auto again = read_camera(copy);
    expect(again && again->eye == camera->eye && again->target == camera->target &&
               again->field_of_view_deg == camera->field_of_view_deg,
           "a camera comes back as it was written");
  }
  if (const auto cameras = read_cameras(path))
    expect(write_cameras(*cameras, copy).has_value(), "cameras that were read can be written");
}

}  // namespace lode::fuzz
