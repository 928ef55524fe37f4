#include "tests/io/volume_spool_files.h"

#include <csignal>
#include <random>

namespace lode::io::test {
namespace {

constexpr std::size_t kSamples = 64 * 50 * 48;
const std::string kSizes = "64 50 48";

/// Samples of 16 bits.
const std::string& shorts() {
  static const std::string kBytes = noise(2 * kSamples);
  return kBytes;
}

SpoolSeed seed_of(std::string name, std::function<SpoolFiles()> make_files) {
  return {.name = std::move(name),
          .make_files = std::move(make_files),
          .options = {},
          .n_bytes = 2 * kSamples};
}

std::vector<SpoolSeed> nrrd_seeds() {
  const std::string start =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: " + kSizes + "\nendian: big\nencoding: gzip\n";
  SpoolSeed vectors = seed_of("nrrd_vectors", [] {
    return SpoolFiles{{"v.nrrd", "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 " + kSizes +
                                     "\nkinds: vector domain domain domain\nencoding: gzip\n\n" +
                                     gzipped(noise(3 * kSamples))}};
  });
  vectors.n_bytes = 3 * kSamples;
  vectors.options.component = Magnitude{};
  return {seed_of("nrrd",
                  [=] {
                    return SpoolFiles{{"a.nrrd", start + "\n" + gzipped(shorts())}};
                  }),
          seed_of("nrrd_detached",
                  [=] {
                    return SpoolFiles{{"d.raw.gz", gzipped("skipped" + shorts())},
                                      {"d.nhdr", start + "byte skip: 7\ndata file: d.raw.gz\n"}};
                  }),
          std::move(vectors)};
}

std::vector<SpoolSeed> nifti_seeds() {
  const NiftiBytes plain({64, 50, 48}, 4);
  NiftiBytes scaled = plain;
  scaled.set<float>(112, 2).set<float>(116, -1);
  NiftiBytes pair = plain;
  pair.set_text(344, "ni1").set<float>(108, 8);
  std::vector<SpoolSeed> seeds = {
      seed_of("nifti",
              [=] {
                return SpoolFiles{{"a.nii.gz", gzipped(plain.bytes() + shorts())}};
              }),
      seed_of("nifti_scaled",
              [=] {
                return SpoolFiles{{"b.nii.gz", gzipped(scaled.bytes() + shorts())}};
              }),
      seed_of("nifti_pair", [=] {
        return SpoolFiles{{"c.hdr.gz", gzipped(pair.bytes())},
                          {"c.img.gz", gzipped("8 bytes." + shorts())}};
      })};
  for (SpoolSeed& seed : seeds) seed.header_piece = std::uint64_t{1} << 18;
  return seeds;
}

std::vector<SpoolSeed> other_seeds() {
  const std::string meta = "NDims = 3\nDimSize = " + kSizes +
                           "\nElementType = MET_SHORT\nCompressedData = True\nElementDataFile = ";
  SpoolSeed raw = seed_of("raw", [] { return SpoolFiles{{"a.raw.gz", gzipped(shorts())}}; });
  raw.options.raw = RawLayout{.dims = kSpoolDims, .type = ScalarType::int16};
  return {seed_of("metaimage",
                  [=] {
                    return SpoolFiles{{"a.mha", meta + "LOCAL\n" + zlibbed(shorts())}};
                  }),
          seed_of("metaimage_detached",
                  [=] {
                    return SpoolFiles{{"b.zraw", zlibbed(shorts())}, {"b.mhd", meta + "b.zraw\n"}};
                  }),
          std::move(raw)};
}

}  // namespace

std::string noise(std::size_t n) {
  std::mt19937_64 random(7);
  std::string bytes(n, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::uint64_t SpoolSeed::most_file_bytes(const SpoolFiles& files) const {
  std::uint64_t n = 0;
  for (const auto& [file, bytes] : files) n += bytes.size();
  return n + std::min<std::uint64_t>(header_piece, n);
}

std::vector<SpoolSeed> spool_seeds() {
  std::vector<SpoolSeed> seeds;
  for (auto& group : {nrrd_seeds(), nifti_seeds(), other_seeds()})
    seeds.insert(seeds.end(), group.begin(), group.end());
  return seeds;
}

ReadOptions spooling(ReadOptions options, const std::string& directory) {
  options.memory_limit = 20;
  options.spool_directory = directory;
  return options;
}

std::vector<SpoolSeed> part_spool_seeds() {
  const auto seed = [](const char* name, const std::string& header, auto add_slice) {
    return seed_of(name, [=] {
      SpoolFiles files;
      const std::size_t n_slice = shorts().size() / 48;
      for (std::size_t z = 0; z < 48; ++z)
        add_slice(files, z, "skipped" + shorts().substr(z * n_slice, n_slice));
      files.emplace_back("slices.nhdr", "NRRD0004\ntype: short\ndimension: 3\nsizes: " + kSizes +
                                            "\nendian: little\nbyte skip: 7\n" + header);
      return files;
    });
  };
  SpoolSeed raw = seed("nrrd_raw_slices", "encoding: raw\ndata file: s%02d.raw 0 47 1\n",
                       [](SpoolFiles& files, std::size_t z, const std::string& slice) {
                         files.emplace_back(fmt::format("s{:02}.raw", z), slice);
                       });
  raw.is_spooled = false;
  return {std::move(raw), seed("nrrd_gzip_slices", "encoding: gzip\ndata file: s%02d.gz 0 47 1\n",
                               [](SpoolFiles& files, std::size_t z, const std::string& slice) {
                                 files.emplace_back(fmt::format("s{:02}.gz", z), gzipped(slice));
                               })};
}

std::string vtk_image(const VtkText& text) {
  const std::string extent = "Extent=\"0 63 0 49 0 47\">";
  return "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt32\"" +
         text.root + "><ImageData Whole" + extent + "<Piece " + extent +
         "<PointData><DataArray type=\"Int16\" Name=\"v\" " + text.array + ">" + text.content +
         "</DataArray></PointData></Piece></ImageData>" + text.appended + "</VTKFile>";
}

VtkBlocked vtk_blocked(const std::string& bytes, std::size_t block) {
  std::vector<std::uint32_t> header = {
      static_cast<std::uint32_t>((bytes.size() + block - 1) / block),
      static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(bytes.size() % block)};
  std::string blocks;
  for (std::size_t i = 0; i < bytes.size(); i += block) {
    const std::string piece = zlibbed(bytes.substr(i, block));
    header.push_back(static_cast<std::uint32_t>(piece.size()));
    blocks += piece;
  }
  return {.header = bytes_of(header), .blocks = std::move(blocks)};
}

namespace {

std::string counted_shorts() {
  return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(shorts().size())}) + shorts();
}

std::string raw_appended(const VtkBlocked& data) {
  return "<AppendedData encoding=\"raw\">_" + data.header + data.blocks + "</AppendedData>";
}

std::string base64_appended(const std::string& text) {
  return "<AppendedData encoding=\"base64\">_" + text + "</AppendedData>";
}

/// Both in base64, each by itself.
std::string base64_blocks() {
  const auto [header, blocks] = vtk_blocked(shorts(), 32768);
  return base64(header) + base64(blocks);
}

SpoolSeed vtk_seed(const std::string& name, const std::function<VtkText()>& make_text) {
  SpoolSeed seed = seed_of(name, [=] {
    return SpoolFiles{{name + ".vti", vtk_image(make_text())}};
  });
  seed.header_piece = std::uint64_t{1} << 20;
  return seed;
}

}  // namespace

std::vector<SpoolSeed> vtk_spool_seeds() {
  SpoolSeed small = vtk_seed("vtk_small_blocks", [] {
    return VtkText{.root = kVtkZlib,
                   .array = kVtkAppended,
                   .appended = raw_appended(vtk_blocked(shorts(), 32768))};
  });
  small.is_spooled = false;
  return {
      std::move(small),
      vtk_seed("vtk_one_block",
               [] {
                 return VtkText{.root = kVtkZlib,
                                .array = kVtkAppended,
                                .appended = raw_appended(vtk_blocked(shorts(), shorts().size()))};
               }),
      vtk_seed("vtk_appended_base64",
               [] {
                 return VtkText{.array = kVtkAppended,
                                .appended = base64_appended(base64(counted_shorts()))};
               }),
      vtk_seed("vtk_appended_base64_blocks",
               [] {
                 return VtkText{.root = kVtkZlib,
                                .array = kVtkAppended,
                                .appended = base64_appended(base64_blocks())};
               }),
      vtk_seed("vtk_inline",
               [] { return VtkText{.array = kVtkBinary, .content = base64(counted_shorts())}; }),
      vtk_seed("vtk_inline_blocks", [] {
        return VtkText{.root = kVtkZlib, .array = kVtkBinary, .content = base64_blocks()};
      })};
}

std::vector<std::byte> read_box(VolumeSource& source, const IndexBox& box) {
  std::vector<std::byte> out(static_cast<std::size_t>(box.n_samples()) *
                             size_of(source.info().type));
  const auto status = source.read(box, out);
  EXPECT_TRUE(status) << status.error().message;
  return out;
}

FileSizeLimit::FileSizeLimit(std::uint64_t n_bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
  EXPECT_EQ(::getrlimit(RLIMIT_FSIZE, &before_), 0);
  const rlimit limit{.rlim_cur = n_bytes, .rlim_max = before_.rlim_max};
  EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
}

FileSizeLimit::~FileSizeLimit() {
  ::setrlimit(RLIMIT_FSIZE, &before_);
  std::signal(SIGXFSZ, handler_);
}

}  // namespace lode::io::test
