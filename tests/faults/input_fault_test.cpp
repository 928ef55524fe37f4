// Opening and reading each kind of volume while calls fail.
#include <memory>

#include "tests/faults/fault_scratch.h"
#include "tests/faults/fault_storm.h"
#include "tests/io/zarr_fixtures.h"

namespace lode::test {
namespace {

using io::ReadOptions;
using io::test::base64;
using io::test::bytes_of;
using io::test::gzipped;
using io::test::ramp;
using io::test::zlibbed;

/// A volume file, whose directory may hold more that belongs to it.
struct Input {
  std::string path;
  std::string directory;
  ReadOptions options;
};

class fault_input : public FaultTest {
 protected:
  fault_input() { values_ = bytes_of(ramp<std::int16_t>(kSamples)); }

  /// A file of that name, which holds values_ in one way or another.
  Input write(const std::string& name, const std::string& bytes, ReadOptions options = {}) {
    return {dir_.write(name, bytes), dir_.path(""), std::move(options)};
  }

  /// Opening, then reading all.
  static void expect_reads(const Input& input) {
    Result<Volume> volume = fail("not read yet");
    const auto expected = io::test::read_volume(input.path, input.options);
    ASSERT_TRUE(expected) << expected.error().message;
    Operation operation;
    operation.files = {input.directory};
    operation.run = [&]() -> Result<void> {
      volume = io::test::read_volume(input.path, input.options);
      if (!volume) return std::move(volume).error();
      return {};
    };
    operation.expect_done = [&] { EXPECT_EQ(volume->samples, expected->samples); };
    expect_survives_all(operation);
    expect_reads_again(input, expected->samples);
  }

  /// A source that has failed once gives what is right, or goes on to fail.
  static void expect_reads_again(const Input& input, const std::vector<std::byte>& expected) {
    std::unique_ptr<VolumeSource> source;
    std::vector<std::byte> samples(expected.size());
    const auto read = [&] { return source->read(source->info().grid.index_box(), samples); };
    const auto open = [&] { source = io::open_volume(input.path, input.options).value(); };
    Operation operation;
    operation.files = {input.directory};
    operation.prepare = open;
    operation.run = read;
    operation.run_again = [&]() -> Result<void> {
      if (auto again = read()) return again;
      open();
      return read();
    };
    operation.expect_done = [&] {
      EXPECT_EQ(samples, expected);
      std::ranges::fill(samples, std::byte{0});
    };
    for (const Fault fault : {Fault::memory, Fault::read, Fault::write, Fault::short_read})
      expect_survives(operation, fault);
  }

  static constexpr std::size_t kSamples = 24;
  static constexpr const char* kNrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: ";

  std::string values_;
  io::test::TempDir dir_;
};

TEST_F(fault_input, as_raw_samples_ends_in_an_error_or_the_samples) {
  ReadOptions options;
  options.raw = io::RawLayout{.dims = {{4, 3, 2}}, .type = ScalarType::int16};
  expect_reads(write("a.raw", values_, options));
}

TEST_F(fault_input, as_nrrd_ends_in_an_error_or_the_samples) {
  expect_reads(write("a.nrrd", kNrrd + ("raw\n\n" + values_)));
  expect_reads(write("b.nrrd", kNrrd + ("gzip\n\n" + gzipped(values_))));
  std::string numbers;
  for (std::size_t i = 0; i < kSamples; ++i) numbers += fmt::format("{} ", i);
  expect_reads(write("c.nrrd", kNrrd + ("ascii\n\n" + numbers)));
  const std::string half = values_.substr(0, values_.size() / 2);
  dir_.write("0.raw", half);
  dir_.write("1.raw", half);
  expect_reads(write("d.nhdr", kNrrd + std::string("raw\ndata file: LIST\n0.raw\n1.raw\n")));
}

TEST_F(fault_input, kept_in_a_spool_ends_in_an_error_or_the_samples) {
  // More than the spool keeps in memory.
  const std::string values = bytes_of(ramp<std::int16_t>(std::size_t{64} * 64 * 16));
  const std::string header =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 64 64 16\nendian: little\nencoding: ";
  ReadOptions options;
  options.memory_limit = 1;
  options.spool_directory = dir_.path("");
  expect_reads(write("spooled.nrrd", header + "gzip\n\n" + gzipped(values), options));
}

TEST_F(fault_input, as_metaimage_ends_in_an_error_or_the_samples) {
  const std::string header = "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n";
  expect_reads(write(
      "a.mha", header + "CompressedData = True\nElementDataFile = LOCAL\n" + zlibbed(values_)));
  dir_.write("b.raw", values_);
  expect_reads(write("b.mhd", header + "ElementDataFile = b.raw\n"));
}

TEST_F(fault_input, as_nifti_ends_in_an_error_or_the_samples) {
  io::test::NiftiBytes nifti({4, 3, 2}, 4);
  nifti.set<float>(112, 2);  // a slope
  expect_reads(write("a.nii", nifti.bytes() + values_));
  expect_reads(write("a.nii.gz", gzipped(nifti.bytes() + values_)));
}

TEST_F(fault_input, as_vtk_xml_ends_in_an_error_or_the_samples) {
  const auto image = [&](const std::string& root, const std::string& array,
                         const std::string& appended) {
    return "<VTKFile type=\"ImageData\" " + root +
           "><ImageData WholeExtent=\"0 3 0 2 0 1\" Spacing=\"1 2 3\"><Piece Extent=\"0 3 0 2 0 "
           "1\"><PointData><DataArray type=\"Int16\" Name=\"v\" " +
           array + "</DataArray></PointData></Piece></ImageData>" + appended + "</VTKFile>";
  };
  const std::string counted =
      bytes_of<std::uint32_t>({static_cast<std::uint32_t>(values_.size())}) + values_;
  expect_reads(write("a.vti", image("", "format=\"binary\">" + base64(counted), "")));
  const std::string block = zlibbed(values_);
  const std::string header =
      bytes_of<std::uint64_t>({1, values_.size(), 0, static_cast<std::uint64_t>(block.size())});
  const Input blocks =
      write("b.vti", image("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"",
                           "format=\"appended\" offset=\"0\">",
                           "<AppendedData encoding=\"raw\">_" + header + block));
  expect_reads(blocks);
  ReadOptions frugal;
  frugal.memory_limit = 1;
  expect_reads({blocks.path, blocks.directory, frugal});
}

TEST_F(fault_input, as_legacy_vtk_ends_in_an_error_or_the_samples) {
  const std::string header = "# vtk DataFile Version 3.0\ntitle\n";
  const std::string points =
      "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 24\n"
      "SCALARS v short 1\nLOOKUP_TABLE default\n";
  expect_reads(write("a.vtk", header + "BINARY\n" + points + values_));
}

TEST_F(fault_input, as_zarr_ends_in_an_error_or_the_samples) {
  for (const char* name : {"v2/fill_42", "v2/codec_zstd", "v3/shard_zstd", "v3/image"}) {
    const io::test::ZarrFixture fixture(name);
    ReadOptions options;
    if (std::string(name) == "v3/image") options = {.component = 0, .time = 0};
    options.threads = {2};
    SCOPED_TRACE(name);
    expect_reads({fixture.path(), fixture.path(), options});
  }
}

}  // namespace
}  // namespace lode::test
