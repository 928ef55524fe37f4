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

SpoolSeed seed_of(std::string name, std::vector<std::pair<std::string, std::string>> files) {
  return {
      .name = std::move(name), .files = std::move(files), .options = {}, .n_bytes = 2 * kSamples};
}

std::vector<SpoolSeed> nrrd_seeds() {
  const std::string start =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: " + kSizes + "\nendian: big\nencoding: gzip\n";
  SpoolSeed vectors = seed_of(
      "nrrd_vectors", {{"v.nrrd", "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 " + kSizes +
                                      "\nkinds: vector domain domain domain\nencoding: gzip\n\n" +
                                      gzipped(noise(3 * kSamples))}});
  vectors.n_bytes = 3 * kSamples;
  vectors.options.component = Magnitude{};
  return {seed_of("nrrd", {{"a.nrrd", start + "\n" + gzipped(shorts())}}),
          seed_of("nrrd_detached", {{"d.raw.gz", gzipped("skipped" + shorts())},
                                    {"d.nhdr", start + "byte skip: 7\ndata file: d.raw.gz\n"}}),
          std::move(vectors)};
}

std::vector<SpoolSeed> nifti_seeds() {
  const NiftiBytes plain({64, 50, 48}, 4);
  NiftiBytes scaled = plain;
  scaled.set<float>(112, 2).set<float>(116, -1);
  NiftiBytes pair = plain;
  pair.set_text(344, "ni1").set<float>(108, 8);
  return {seed_of("nifti", {{"a.nii.gz", gzipped(plain.bytes() + shorts())}}),
          seed_of("nifti_scaled", {{"b.nii.gz", gzipped(scaled.bytes() + shorts())}}),
          seed_of("nifti_pair", {{"c.hdr.gz", gzipped(pair.bytes())},
                                 {"c.img.gz", gzipped("8 bytes." + shorts())}})};
}

std::vector<SpoolSeed> other_seeds() {
  const std::string meta = "NDims = 3\nDimSize = " + kSizes +
                           "\nElementType = MET_SHORT\nCompressedData = True\nElementDataFile = ";
  SpoolSeed raw = seed_of("raw", {{"a.raw.gz", gzipped(shorts())}});
  raw.options.raw = RawLayout{.dims = kSpoolDims, .type = ScalarType::int16};
  return {
      seed_of("metaimage", {{"a.mha", meta + "LOCAL\n" + zlibbed(shorts())}}),
      seed_of("metaimage_detached", {{"b.zraw", zlibbed(shorts())}, {"b.mhd", meta + "b.zraw\n"}}),
      std::move(raw)};
}

}  // namespace

std::string noise(std::size_t n) {
  std::mt19937_64 random(7);
  std::string bytes(n, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::uint64_t SpoolSeed::most_file_bytes() const {
  std::uint64_t n = 0;
  for (const auto& [file, bytes] : files) n += bytes.size();
  // Headers, compressed or not, are looked at on their own before.
  constexpr std::uint64_t kHeaders = std::uint64_t{1} << 18;
  return n + kHeaders;
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
