#include <random>

#include "tests/io/volume_test_files.h"
#include "tests/oracles/trials.h"

namespace lode::io {
namespace {

using test::base64;
using test::bytes_of;
using test::gzipped;
using test::mutated;
using test::ramp;
using test::TempDir;
using test::zlibbed;

/// A small valid file of one format and what it takes to read it.
struct Seed {
  const char* name;
  std::string bytes;
  bool needs_layout = false;
};

std::string vti(const std::string& root, const std::string& array, const std::string& appended) {
  return "<VTKFile type=\"ImageData\" " + root +
         "><ImageData WholeExtent=\"0 3 0 2 0 1\" Spacing=\"1 2 3\"><Piece Extent=\"0 3 0 2 0 "
         "1\"><PointData><DataArray type=\"Int16\" Name=\"v\" " +
         array + "</DataArray></PointData></Piece></ImageData>" + appended + "</VTKFile>";
}

std::vector<Seed> text_header_seeds() {
  const std::string raw = bytes_of(ramp<std::int16_t>(24));
  const std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 4\nsizes: 1 4 3 2\nendian: little\n"
      "kinds: vector domain domain domain\nspace: RAS\nspace directions: none "
      "(1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2,3)\nencoding: ";
  const std::string meta =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nOffset = 1 2 3\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementSpacing = 1 1 1\n";
  const std::string legacy = "# vtk DataFile Version 3.0\ntitle\n";
  const std::string points =
      "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nSPACING 1 1 1\n"
      "ORIGIN 0 0 0\nPOINT_DATA 24\nSCALARS v short 1\nLOOKUP_TABLE t\n";
  std::string numbers;
  for (int i = 0; i < 24; ++i) numbers += fmt::format("{} ", i);
  return {{"a.nrrd", nrrd + "raw\n\n" + raw},
          {"b.nrrd", nrrd + "gzip\n\n" + gzipped(raw)},
          {"c.nrrd", nrrd + "ascii\n\n" + numbers},
          {"d.nrrd", nrrd + "hex\n\n" + std::string(96, 'a')},
          // Their own data files, so that one file is enough.
          {"e.nhdr", nrrd + "raw\nbyte skip: -1\ndata file: LIST 3\ne.nhdr\ne.nhdr\n\n" + raw},
          {"f1.nhdr", nrrd + "raw\nbyte skip: -1\ndata file: f%d.nhdr 1 1 1 4\n\n" + raw},
          {"a.mha", meta + "ElementDataFile = LOCAL\n" + raw},
          {"b.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + zlibbed(raw)},
          {"a.vtk", legacy + "BINARY\n" + points + raw},
          {"b.vtk", legacy + "ASCII\n" + points + numbers},
          {"c.vtk", legacy + "ASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 2 2 1\nX_COORDINATES 2 "
                             "float\n0 1\nY_COORDINATES 2 float\n0 1\nZ_COORDINATES 1 float\n0\n"
                             "POINT_DATA 4\nFIELD f 1\nv 1 4 int\n1 2 3 4\n"}};
}

std::vector<Seed> binary_seeds() {
  const std::string raw = bytes_of(ramp<std::int16_t>(24));
  test::NiftiBytes nifti({4, 3, 2}, 4);
  nifti.set_sform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}).set<float>(112, 2);
  const std::string counted = bytes_of<std::uint32_t>({48}) + raw;
  const std::string block = zlibbed(raw);
  const std::string header =
      bytes_of<std::uint64_t>({1, 48, 0, static_cast<std::uint64_t>(block.size())});
  const std::string zlib = "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"";
  const std::string appended = "format=\"appended\" offset=\"0\">";
  return {{"a.nii", nifti.bytes() + raw},
          {"a.nii.gz", gzipped(nifti.bytes() + raw)},
          {"a.vti", vti("", "format=\"binary\">" + base64(counted), "")},
          {"b.vti", vti(zlib, "format=\"binary\">" + base64(header) + base64(block), "")},
          {"c.vti", vti("", appended, "<AppendedData encoding=\"raw\">_" + counted)},
          {"d.vti", vti(zlib, appended, "<AppendedData encoding=\"raw\">_" + header + block)},
          {"e.vti", vti(zlib, appended,
                        "<AppendedData encoding=\"base64\">_" + base64(header) + base64(block))},
          {"a.raw", raw, true},
          {"a.raw.gz", gzipped(raw), true}};
}

/// Decoding while reading comes to what decoding while opening came to.
void expect_same_with_little_memory(const std::string& path, ReadOptions options,
                                    const Result<Volume>& volume) {
  options.memory_limit = 1;
  const auto spooled = test::read_volume(path, options);
  if (volume && spooled) {
    EXPECT_EQ(spooled->samples, volume->samples);
  } else if (volume) {
    EXPECT_NE(spooled.error().message.find("memory limit"), std::string::npos)
        << spooled.error().message;
  } else {
    EXPECT_FALSE(spooled) << volume.error().message;
  }
}

class volume_reader_fuzz : public testing::TestWithParam<Seed> {};

TEST_P(volume_reader_fuzz, survives_any_bytes) {
  const TempDir dir;
  const Seed& seed = GetParam();
  ReadOptions options;
  if (seed.needs_layout) options.raw = RawLayout{.dims = {{4, 3, 2}}, .type = ScalarType::int16};
  const auto original = test::read_volume(dir.write(seed.name, seed.bytes), options);
  ASSERT_TRUE(original) << original.error().message;

  constexpr std::uint64_t kSeed = 20240607;
  SCOPED_TRACE(fmt::format("seed {}", kSeed));
  std::mt19937_64 random(kSeed);
  const int n_rounds = oracles::trials(1500, 400);
  for (int round = 0; round < n_rounds; ++round) {
    const std::string path = dir.write(seed.name, mutated(seed.bytes, random));
    const auto volume = test::read_volume(path, options);
    expect_same_with_little_memory(path, options, volume);
    if (volume) continue;
    EXPECT_NE(volume.error().message.find(dir.path("")), std::string::npos)
        << volume.error().message;
  }
}

TEST_P(volume_reader_fuzz, refuses_or_reads_every_truncation) {
  const TempDir dir;
  const Seed& seed = GetParam();
  ReadOptions options;
  if (seed.needs_layout) options.raw = RawLayout{.dims = {{4, 3, 2}}, .type = ScalarType::int16};
  for (std::size_t n = 0; n < seed.bytes.size(); ++n) {
    const auto path = dir.write(seed.name, seed.bytes.substr(0, n));
    const auto volume = test::read_volume(path, options);
    expect_same_with_little_memory(path, options, volume);
    if (!volume) EXPECT_FALSE(volume.error().message.empty());
  }
}

std::string seed_name(const testing::TestParamInfo<Seed>& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(text_headers, volume_reader_fuzz, testing::ValuesIn(text_header_seeds()),
                         seed_name);
INSTANTIATE_TEST_SUITE_P(binary, volume_reader_fuzz, testing::ValuesIn(binary_seeds()), seed_name);

}  // namespace
}  // namespace lode::io
