// Writes small valid inputs of every harness, the fuzzers' first ones: fuzz_seeds
// tests/fuzz/corpus.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/point_terrain.h"
#include "lode/api/tetra_dataset.h"
#include "lode/io/quantized_mesh.h"
#include "lode/io/surface_file.h"
#include "lode/models/diamond/stream_build.h"
#include "lode/render/camera_file.h"
#include "lode/store/codec.h"
#include "lode/store/directory.h"
#include "lode/store/header.h"
#include "lode/store/journal.h"
#include "tests/fuzz/seeds.h"
#include "tests/io/zarr_fixtures.h"
#include "tests/models/stored_fixtures.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::fuzz {

std::filesystem::path corpus;

void keep(const std::string& harness, const std::string& name, const std::string& bytes) {
  std::filesystem::create_directories(corpus / harness);
  std::ofstream(corpus / harness / name, std::ios::binary) << bytes;
}

std::string joined(const std::string& first, const std::string& second) {
  return io::test::bytes_of<std::uint16_t>({static_cast<std::uint16_t>(first.size())}) + first +
         second;
}

namespace {

using io::test::base64;
using io::test::bytes_of;
using io::test::gzipped;
using io::test::ramp;
using io::test::zlibbed;

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void keep_lode_file(const std::string& name, const Volume& volume) {
  const io::test::TempDir dir;
  const std::string path = dir.path("a.lode");
  const Index3& dims = volume.info.grid.dims;
  if (std::min({dims[0], dims[1], dims[2]}) == 1)
    test::save<2>(test::built<2>(volume), path);
  else
    test::save<3>(test::built<3>(volume), path);
  keep("lode_file", name, load(path));
  if (name != "small") return;
  const std::string bytes = load(path);
  keep("directory", "header", bytes.substr(0, store::kHeaderBytes));
  const auto reader = store::Reader::open(path);
  const store::Directory directory{reader->model(),
                                   {reader->metadata().begin(), reader->metadata().end()},
                                   {reader->blocks().begin(), reader->blocks().end()}};
  const store::BlockEntry& last = directory.blocks.back();
  const auto end = static_cast<std::uint32_t>(last.offset + last.stored_size);
  keep("directory", "directory",
       bytes_of<std::uint32_t>({end}) + text_of(store::encode_directory(directory)));
}

/// A file's indexes as run_index() takes them.
void keep_indexes() {
  const io::test::TempDir dir;
  const std::string path = dir.path("a.lode");
  test::save<3>(
      test::built<3>(test::random_samples({{17, 5, 300}}, ScalarType::uint8, test::Holes::none)),
      path);
  const auto reader = store::Reader::open(path);
  store::Directory run{reader->model(), {}, {}};
  std::string records;
  for (const store::BlockEntry& block : reader->blocks()) {
    if (store::is_index(block.key) && !run.blocks.empty()) {
      records += joined(std::string(1, '\0') + text_of(store::encode_directory(run)), "");
      run.blocks.clear();
    }
    if (!store::is_index(block.key)) run.blocks.push_back(block);
  }
  keep("index", "build", records);
}

void keep_lode_files() {
  using test::Holes;
  keep_lode_file("small", test::random_samples({{5, 4, 3}}, ScalarType::uint8, Holes::none));
  keep_lode_file("holes", test::random_samples({{9, 6, 5}}, ScalarType::float32, Holes::some));
  keep_lode_file("flat", test::random_samples({{20, 9, 1}}, ScalarType::int16, Holes::none));
  keep_lode_file("levels", test::random_samples({{17, 17, 17}}, ScalarType::uint8, Holes::none));
  keep_lode_file("wide", test::random_samples({{3, 2, 4}}, ScalarType::float64, Holes::none));
}

void keep_codecs() {
  const auto raw = bytes_of(ramp<std::int32_t>(50));
  for (unsigned codec = 0; codec <= store::kLastCodec; ++codec) {
    const auto block = store::encode_block_as(
        static_cast<store::Codec>(codec),
        {std::as_bytes(std::span(raw)), 4, store::ElementGrid{{5, 5, 2}, false}});
    const auto n = static_cast<std::uint8_t>(raw.size());
    keep("codec", "codec_" + std::to_string(codec),
         bytes_of<std::uint8_t>({static_cast<std::uint8_t>(block.codec), 4, n, 0, 0}) +
             text_of(block.stored));
  }
}

/// Stops a build in parts after its first one.
class StoppingSource final : public VolumeSource {
 public:
  explicit StoppingSource(const Volume& volume) : source_(make_memory_source(volume)) {}
  const VolumeInfo& info() const override { return source_->info(); }
  Result<void> read(const IndexBox& box, std::span<std::byte> out) override {
    constexpr int kReadsOfScanAndOnePart = 2;
    if (++n_reads_ > kReadsOfScanAndOnePart) return fail("that is enough");
    return source_->read(box, out);
  }

 private:
  std::unique_ptr<VolumeSource> source_;
  int n_reads_ = 0;
};

void keep_journals() {
  const Volume volume = test::random_samples({{600, 4, 4}}, ScalarType::uint8, test::Holes::none);
  StoppingSource source(volume);
  const io::test::TempDir dir;
  const std::string output = dir.path("out.lode");
  Progress progress;
  const diamond::StreamSettings settings{
      .threads = {1}, .unfinished = Unfinished::part, .chunks_per_part = 1};
  static_cast<void>(diamond::build_file<3>(source, output, settings, progress).has_value());
  const std::string path = output + ".part.journal";
  keep("journal", "build", load(path));
  std::string records;
  bool is_head = true;
  static_cast<void>(store::Journal::reopen(path, [&](std::span<const std::byte> r) -> Result<bool> {
                      if (!std::exchange(is_head, false)) records += joined(text_of(r), "");
                      return true;
                    }).has_value());
  keep("part_log", "build", records);
}

constexpr const char* kNrrd =
    "NRRD0004\ntype: short\ndimension: 4\nsizes: 1 4 3 2\nendian: little\n"
    "kinds: vector domain domain domain\nspace: RAS\nspace directions: none "
    "(1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2,3)\nencoding: ";

std::string numbers() {
  std::string text;
  for (int i = 0; i < 24; ++i) text += fmt::format("{} ", i);
  return text;
}

void keep_text_headers() {
  const std::string raw = bytes_of(ramp<std::int16_t>(24));
  keep("nrrd", "raw", kNrrd + ("raw\n\n" + raw));
  keep("nrrd", "gzip", kNrrd + ("gzip\n\n" + gzipped(raw)));
  keep("nrrd", "ascii", kNrrd + ("ascii\n\n" + numbers()));
  keep("nrrd", "hex", kNrrd + ("hex\n\n" + std::string(96, 'a')));
  keep("nrrd", "list", kNrrd + ("raw\nbyte skip: -1\ndata file: LIST 3\na.nhdr\na.nhdr\n\n" + raw));
  keep("nrrd", "spacings",
       "NRRD0001\ntype: double\ndimension: 3\nsizes: 2 1 2\nspacings: 1 2 .5\naxis mins: 0 1 2\n"
       "endian: big\nline skip: 0\nencoding: raw\n\n" +
           bytes_of(ramp<double>(4)));
  const std::string meta =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nOffset = 1 2 3\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementSpacing = 1 1 1\n";
  keep("metaimage", "raw", meta + "ElementDataFile = LOCAL\n" + raw);
  keep("metaimage", "zlib",
       meta + "CompressedData = True\nElementDataFile = LOCAL\n" + zlibbed(raw));
  keep("metaimage", "text", meta + "BinaryData = False\nElementDataFile = LOCAL\n" + numbers());
  const std::string legacy = "# vtk DataFile Version 3.0\ntitle\n";
  const std::string points =
      "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nSPACING 1 1 1\n"
      "ORIGIN 0 0 0\nPOINT_DATA 24\nSCALARS v short 1\nLOOKUP_TABLE t\n";
  keep("vtk_legacy", "binary", legacy + "BINARY\n" + points + raw);
  keep("vtk_legacy", "ascii", legacy + "ASCII\n" + points + numbers());
  keep("vtk_legacy", "rectilinear",
       legacy +
           "ASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 2 2 1\nX_COORDINATES 2 float\n0 1\n"
           "Y_COORDINATES 2 float\n0 1\nZ_COORDINATES 1 float\n0\nPOINT_DATA 4\nFIELD f 1\n"
           "v 1 4 int\n1 2 3 4\n");
}

std::string vti(const std::string& root, const std::string& array, const std::string& appended) {
  return "<VTKFile type=\"ImageData\" " + root +
         "><ImageData WholeExtent=\"0 3 0 2 0 1\" Spacing=\"1 2 3\"><Piece Extent=\"0 3 0 2 0 "
         "1\"><PointData><DataArray type=\"Int16\" Name=\"v\" " +
         array + "</DataArray></PointData></Piece></ImageData>" + appended + "</VTKFile>";
}

void keep_binaries() {
  const std::string raw = bytes_of(ramp<std::int16_t>(24));
  io::test::NiftiBytes nifti({4, 3, 2}, 4);
  nifti.set_sform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}).set<float>(112, 2);
  keep("nifti", "plain", nifti.bytes() + raw);
  keep("nifti", "gzip", gzipped(nifti.bytes() + raw));
  const std::string counted = bytes_of<std::uint32_t>({48}) + raw;
  const std::string block = zlibbed(raw);
  const std::string header =
      bytes_of<std::uint64_t>({1, 48, 0, static_cast<std::uint64_t>(block.size())});
  const std::string zlib = "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"";
  const std::string appended = "format=\"appended\" offset=\"0\">";
  keep("vtk_xml", "ascii", vti("", "format=\"ascii\">" + numbers(), ""));
  keep("vtk_xml", "base64", vti("", "format=\"binary\">" + base64(counted), ""));
  keep("vtk_xml", "base64_zlib",
       vti(zlib, "format=\"binary\">" + base64(header) + base64(block), ""));
  keep("vtk_xml", "raw", vti("", appended, "<AppendedData encoding=\"raw\">_" + counted));
  keep("vtk_xml", "raw_zlib",
       vti(zlib, appended, "<AppendedData encoding=\"raw\">_" + header + block));
}

void keep_zarr() {
  for (const char* name : {"fill_42", "codec_zstd", "codec_blosc_lz4_bits", "codec_gzip"}) {
    const io::test::ZarrFixture fixture(std::string("v2/") + name);
    keep("zarr_v2", name, joined(load(fixture.path(".zarray")), load(fixture.path("0.0.0"))));
  }
  for (const char* name : {"shard_zstd", "shard_nested", "shard_transposed"}) {
    const io::test::ZarrFixture fixture(std::string("v3/") + name);
    keep("zarr_v3", name, joined(load(fixture.path("zarr.json")), load(fixture.path("c/0/0/0"))));
  }
}

void keep_ome_zarr() {
  const io::test::ZarrFixture fixture("v3/image");
  keep("ome_zarr", "image",
       joined(load(fixture.path("zarr.json")), load(fixture.path("s0/zarr.json"))));
}

void keep_surfaces() {
  const io::test::TempDir dir;
  Surface surface;
  surface.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
  surface.normals.assign(4, {{0, 0, 1}});
  surface.isovalues.assign(4, 1.5F);
  surface.triangles = {{0, 1, 2}, {0, 1, 3}};
  Surface lines;
  lines.origin = {{1e6, 0, 0}};
  lines.positions = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
  lines.lines = {{0, 1}, {1, 2}};
  lines.values = {1, 2, 3};
  Progress progress;
  for (const std::string extension : {"ply", "stl", "obj", "vtp", "glb"}) {
    const std::string path = dir.path("a." + extension);
    if (io::write_surface(path, surface, {}, progress)) keep(extension, "triangles", load(path));
    if (io::write_surface(path, lines, {}, progress)) keep(extension, "lines", load(path));
  }
  keep("ply", "ascii",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  keep("ply", "big_endian",
       "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty double x\n"
       "property double y\nproperty double z\nend_header\n" +
           bytes_of<double>({1, 2, 3}, io::ByteOrder::big));
  keep("stl", "ascii",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid a\n");
  Camera camera;
  camera.eye = {{1, 2, 3}};
  if (write_camera(camera, dir.path("c.json"))) keep("camera", "one", load(dir.path("c.json")));
  if (write_cameras({camera, camera}, dir.path("c.json")))
    keep("camera", "path", load(dir.path("c.json")));
}

void keep_tiles() {
  io::QuantizedMesh mesh{.west = 0, .south = 0, .east = 1, .north = 1};
  mesh.highest = 32767;
  mesh.nodes = {{0, 0}, {32767, 0}, {32767, 32767}, {0, 32767}, {9000, 12000}};
  mesh.heights = {0, 1, 32767, 3, 700};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const std::vector<std::byte> bytes = io::encode(mesh);
  keep("quantized_mesh", "tile",
       std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  keep(
      "tile_layer", "two_levels",
      R"({"format":"quantized-mesh-1.0","scheme":"tms","projection":"EPSG:4326","available":)"
      R"([[{"startX":0,"startY":0,"endX":1,"endY":0}],[{"startX":1,"startY":0,"endX":2,"endY":1}]],)"
      R"("errors":[{"achieved_error":2.5},{"achieved_error":1}]})");
}

/// Faces of one tetrahedron on two sides of the unit cube.
void add_patches(TetraMesh& mesh) {
  mesh.patches = {{3, "inlet"}, {8, ""}};
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i) {
      const std::array<std::uint32_t, 3> face{t[(i + 1) % 4], t[(i + 2) % 4], t[(i + 3) % 4]};
      for (const std::uint32_t patch : {0U, 1U})
        if (std::ranges::all_of(
                face, [&](std::uint32_t v) { return mesh.positions[v][2 * patch] == patch; }))
          mesh.patch_faces.push_back({face, patch});
    }
}

void keep_tetra_file(const TetraMesh& mesh, const TetraBuildOptions& options,
                     const std::string& name) {
  const io::test::TempDir dir;
  const std::string path = dir.path("t.lode");
  Progress progress;
  if (!TetraDataset::build_file(mesh, path, options, progress)) std::abort();
  keep("tetra_file", name, load(path));
}

void keep_tetra_files() {
  TetraMesh mesh = oracles::noise_mesh(4, oracles::Cut::in_five, 3);
  mesh.region_ids = {-2, 7};
  mesh.region_names = {"air", "rotor \xC3\xA9"};
  for (const auto& t : mesh.tetrahedra)
    mesh.regions.push_back(mesh.positions[t[0]][0] < 0.5 ? 0 : 1);
  TetraBuildOptions options{.base_share = 0.1, .threads = {1}};
  keep_tetra_file(mesh, options, "half_edge");
  MeshField& waves = mesh.fields.emplace_back(mesh.fields[0]);
  waves.name = "waves";
  waves.type = ScalarType::float64;
  for (double& value : waves.values) value = std::sin(9 * value) / 3;
  options.placement = Placement::midpoint;
  options.has_world_errors = true;
  keep_tetra_file(mesh, options, "midpoint");
  add_patches(mesh);
  options.boundary_tolerance = 0.2;
  options.order = CollapseOrder::quadric;
  keep_tetra_file(mesh, options, "midpoint_patches");
  options.placement = Placement::half_edge;
  keep_tetra_file(mesh, options, "half_edge_patches");
}

/// Hills with a gap, and at the end of a row another.
void keep_terrain_files() {
  HeightGrid grid = make_height_grid<std::int16_t>(12, 9);
  grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 1);
  auto& samples = std::get<HeightGrid::Samples<std::int16_t>>(grid.heights);
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      samples[static_cast<std::size_t>(y * grid.stride + x)] =
          static_cast<std::int16_t>(100 + (x * x * 7 + y * 13 + x * y * 5) % 60);
  grid.is_valid[4 * 12 + 5] = grid.is_valid[2 * 12 + 11] = 0;
  for (const TerrainModel model : kBuiltTerrainModels) {
    const io::test::TempDir dir;
    const std::string path = dir.path("d.lode");
    Progress progress;
    TerrainBuildOptions options;
    options.model = model;
    options.levels = {30, 10, 2};
    const auto built = BuiltTerrain::build(grid, options, progress);
    if (!built || !built->save(path, progress)) std::abort();
    keep("terrain_file", name_of(model), load(path));
  }
}

/// Scattered points, whose outline is oblique and has a hole.
void keep_terrain_files_of_points() {
  std::vector<Vec3d> points;
  for (int i = 0; i < 80; ++i) {
    const int x = i * 7919 % 1009;
    const int y = i * 104729 % 997;
    const bool is_in_hole = std::abs(x - 500) < 200 && std::abs(y - 500) < 150;
    if (!is_in_hole)
      points.push_back({{1.0 * x, 1.0 * y, static_cast<double>((x * 3 + y * 7) % 40)}});
  }
  for (const TerrainModel model :
       {TerrainModel::adaptive_triangulation, TerrainModel::hierarchical_delaunay,
        TerrainModel::complete_pyramid, TerrainModel::linked_triangle_lists}) {
    const io::test::TempDir dir;
    const std::string path = dir.path("p.lode");
    Progress progress;
    const auto terrain = make_point_terrain(points, {{0, 0}, 1}, {}, {.max_edge = 300}, progress);
    if (!terrain) std::abort();
    TerrainBuildOptions options;
    options.model = model;
    options.levels = {25, 10};
    const auto built = BuiltTerrain::build(*terrain, options, progress);
    if (!built || !built->save(path, progress)) std::abort();
    keep("terrain_file", std::string(name_of(model)) + "_of_points", load(path));
  }
}

}  // namespace
}  // namespace lode::fuzz

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "expected one argument, the directory of the corpus\n");
    return 2;
  }
  lode::fuzz::corpus = argv[1];
  lode::fuzz::keep_lode_files();
  lode::fuzz::keep_tetra_files();
  lode::fuzz::keep_terrain_files();
  lode::fuzz::keep_terrain_files_of_points();
  lode::fuzz::keep_indexes();
  lode::fuzz::keep_codecs();
  lode::fuzz::keep_journals();
  lode::fuzz::keep_text_headers();
  lode::fuzz::keep_binaries();
  lode::fuzz::keep_zarr();
  lode::fuzz::keep_ome_zarr();
  lode::fuzz::keep_surfaces();
  lode::fuzz::keep_meshes();
  lode::fuzz::keep_points();
  lode::fuzz::keep_tiles();
  return 0;
}
