#include "lode/io/imported_raster.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "lode/io/child_program.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

using namespace std::string_view_literals;

constexpr const char* kImporter = "lode-raster-import";
/// 128 and more are signals, as a shell says it.
constexpr int kFirstSignal = 128;
/// Of the loader, as of a shell.
constexpr int kNotLoaded = 127;

std::vector<std::string> import_words(const std::string& program, const std::string& path,
                                      const ImportChoice& choice) {
  // What starts with a dash would be an option.
  std::vector<std::string> words{program, std::filesystem::absolute(path).string(),
                                 "/proc/self/fd/3"};
  if (!choice.variable.empty()) words.insert(words.end(), {"--variable", choice.variable});
  if (choice.layer) words.insert(words.end(), {"--layer", fmt::format("{}", *choice.layer)});
  if (choice.crs_is_stated) words.emplace_back("--crs-is-stated");
  if (choice.nodata_is_stated) words.emplace_back("--nodata-is-stated");
  return words;
}

/// What the program said in all.
struct Said {
  std::string error;
  std::uint64_t n_bytes = 0;
};

void take_line(const std::string& line, ImportedRaster& raster, Said& said, Progress& progress) {
  const std::size_t blank = line.find(' ');
  const std::string_view key = std::string_view(line).substr(0, blank);
  const std::string rest = blank == std::string::npos ? "" : line.substr(blank + 1);
  if (key == "progress") {
    progress.report("copying the raster", to_double(rest).value_or(0), said.n_bytes);
  } else if (key == "bytes") {
    said.n_bytes = static_cast<std::uint64_t>(to_int64(rest).value_or(0));
  } else if (key == "format") {
    raster.format = rest;
  } else if (key == "crs") {
    raster.crs = rest;
  } else if (key == "degrees") {
    raster.is_in_plain_degrees = true;
  } else if (key == "points") {
    raster.is_of_points = true;
  } else if (key == "note") {
    raster.notes.push_back(rest);
  } else if (key == "error") {
    said.error = rest;
  }
}

Result<void> run_importer(const std::string& path, const std::vector<std::string>& words,
                          const ImportProgram& program, ImportedRaster& raster,
                          Progress& progress) {
  LODE_TRY(ChildProgram child,
           ChildProgram::start(words, ChildErrors::dropped, raster.copy.descriptor()));
  Said said;
  while (true) {
    auto line = child.read_line(progress, program.patience);
    if (!line && progress.is_cancelled()) return line.error();
    if (!line)
      return fail("{}: expected a raster that {} can read, which was ended: {}", path, kImporter,
                  line.error().message);
    if (!*line) break;
    take_line(**line, raster, said, progress);
  }
  const int exit_code = child.wait();
  if (progress.is_cancelled()) return cancelled_error();
  if (exit_code == 0) return {};
  if (exit_code == kNotLoaded)
    return fail(
        "{}: expected the program {} to start, which reads such rasters, but one of the libraries "
        "it needs is not there",
        path, words[0]);
  if (exit_code > kFirstSignal)
    return fail(
        "{}: expected a raster that {} can read, got a crash of it ({}): the file may be "
        "damaged",
        path, kImporter, ::strsignal(exit_code - kFirstSignal));
  return fail("{}: {}", path,
              said.error.empty()
                  ? fmt::format("expected a raster that {} can read, which ended with "
                                "exit code {}",
                                kImporter, exit_code)
                  : said.error);
}

}  // namespace

bool is_netcdf(const std::string& path) {
  constexpr std::size_t kSignature = 8;
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) return false;
  std::string head(kSignature, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head.starts_with("CDF\1"sv) || head.starts_with("CDF\2"sv) ||
         head.starts_with("CDF\5"sv) || head == "\x89HDF\r\n\x1a\n"sv;
}

bool is_imported_path(const std::string& path) {
  constexpr std::array kExtensions{
      ".ntf", ".nitf", ".gpkg", ".grb",    ".grib",   ".grb2",   ".grib2", ".adf", ".ers",
      ".rst", ".gtx",  ".lcp",  ".ter",    ".hfz",    ".map",    ".mpr",   ".cub", ".lbl",
      ".isg", ".blx",  ".kro",  ".sigdem", ".asc.gz", ".dem.gz", ".tif.gz"};
  const std::string name = to_lower(path);
  return std::ranges::any_of(kExtensions,
                             [&](const char* extension) { return name.ends_with(extension); });
}

std::string ImportedRaster::name() const {
  return fmt::format("/proc/self/fd/{}", copy.descriptor());
}

Result<ImportedRaster> import_raster(const std::string& path, const ImportChoice& choice,
                                     Progress& progress, const ImportProgram& program) {
  const std::string found =
      program.path.empty() ? find_program(kImporter).value_or("") : program.path;
  if (found.empty())
    return fail(
        "{}: expected the program {}, which reads such rasters, beside lode or in PATH, got none",
        path, kImporter);
  std::error_code status;
  const std::string directory = std::filesystem::temp_directory_path(status).string();
  if (status)
    return fail("{}: expected a directory for a temporary copy (TMPDIR), got: {}", path,
                status.message());
  LODE_TRY(SpoolFile copy, SpoolFile::create(directory, std::make_shared<IoTally>()));
  ImportedRaster raster{.copy = std::move(copy)};
  LODE_CHECK(run_importer(path, import_words(found, path, choice), program, raster, progress));
  return raster;
}

}  // namespace lode::io
