// lode-raster-import: copies a raster from a netCDF file, or another that GDAL reads and lode does
// not, into a GeoTIFF. A program of its own: libraries that read these may crash, hang or take all
// memory over files that are damaged, and lode is to say so and live.
#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <poll.h>
#include <strings.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

#include "classic_size.h"
#include "copy.h"
#include "gdal_file.h"
#include "grid.h"
#include "netcdf_file.h"
#include "outside_files.h"

namespace lode::raster_import {
namespace {

using namespace std::string_view_literals;

constexpr int kFailure = 1;
constexpr int kUsage = 2;
/// Beside what the program and its libraries have when they start.
constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;

constexpr const char* kHelp =
    "Usage: lode-raster-import IN OUT.tif [--variable NAME] [--layer N]\n"
    "                          [--crs-is-stated] [--nodata-is-stated]\n\n"
    "Copies a raster of a netCDF file (classic, 64-bit, CDF-5 or netCDF-4), north up, or a band "
    "of\n"
    "another file that GDAL reads, into a GeoTIFF of the same type, and says on stdout what it\n"
    "does, a line each: progress, bytes, format, crs, degrees, points, note, and error where it\n"
    "fails. lode itself runs it for such files.\n\n"
    "  --variable NAME     Of netCDF: variable over two dimensions (default: the only one)\n"
    "  --layer N           Layer along its other dimensions, or band, from 1\n"
    "  --crs-is-stated     Read also where what the file says of its CRS is not understood\n"
    "  --nodata-is-stated  Leave out what the file says of missing samples\n"
    "  --help              This text\n";

struct Arguments {
  std::string input;
  std::string output;
  Choice choice;
};

std::optional<Arguments> parse_arguments(int argc, char** argv) {
  Arguments arguments;
  int n_paths = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--variable" && i + 1 < argc) {
      arguments.choice.variable = argv[++i];
    } else if (word == "--layer" && i + 1 < argc) {
      const std::string_view text = argv[++i];
      std::size_t layer = 0;
      const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), layer);
      if (status != std::errc() || end != text.data() + text.size() || layer == 0) return {};
      arguments.choice.layer = layer;
    } else if (word == "--crs-is-stated") {
      arguments.choice.crs_is_stated = true;
    } else if (word == "--nodata-is-stated") {
      arguments.choice.nodata_is_stated = true;
    } else if (word.starts_with("--") || n_paths == 2) {
      return {};
    } else {
      (n_paths++ == 0 ? arguments.input : arguments.output) = word;
    }
  }
  return n_paths == 2 ? std::optional(arguments) : std::nullopt;
}

/// A line of what lode reads.
void say(const char* what, std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  std::printf("%s %s\n", what, text.c_str());
  std::fflush(stdout);
}

/// No more memory than that, and no core file.
void limit_self() {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  std::ifstream status("/proc/self/status");
  std::uint64_t n_kib = 0;
  for (std::string word; status >> word;)
    if (word == "VmData:") status >> n_kib;
  const rlim_t most = kMostBytes + n_kib * 1024;
  const rlimit limit{most, most};
  ::setrlimit(RLIMIT_DATA, &limit);
}

enum class Format { classic, hdf5, other };

Format format_of(const std::string& path) {
  std::array<char, 8> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  const std::string_view start(head.data(), static_cast<std::size_t>(file.gcount()));
  if (start == "\x89HDF\r\n\x1a\n"sv) return Format::hdf5;
  for (const std::string_view magic : {"CDF\1"sv, "CDF\2"sv, "CDF\5"sv})
    if (start.starts_with(magic)) return Format::classic;
  return Format::other;
}

void set_up_libraries() {
  ::setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);  // nothing is written
  ::setenv("NCRCENV_IGNORE", "1", 1);             // no settings of libnetcdf's from files
  CPLSetErrorHandler(CPLQuietErrorHandler);
  CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
  CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
  constexpr GIntBig kCache = GIntBig{64} << 20;
  GDALSetCacheMax64(kCache);
  GDALRegister_GTiff();
  GDALRegister_netCDF();
}

/// Tells lode that this is alive.
class Reporter {
 public:
  void operator()(double fraction, std::uint64_t n_bytes) {
    constexpr auto kPause = std::chrono::milliseconds(50);
    const auto now = std::chrono::steady_clock::now();
    if (fraction == 0) say("bytes", std::to_string(n_bytes));
    if (fraction != 0 && now - last_ < kPause) return;
    last_ = now;
    say("progress", std::to_string(fraction));
  }

 private:
  std::chrono::steady_clock::time_point last_{};
};

void import_other(const std::string& input, const Arguments& arguments) {
  const GdalFacts facts = copy_by_gdal(input, arguments.choice, arguments.output, Reporter());
  say("format", facts.format);
  if (!facts.crs.empty()) say("crs", facts.crs);
  if (facts.is_point) say("points", "");
  for (const std::string& note : facts.notes) say("note", note);
}

void import(const Arguments& arguments) {
  // libnetcdf takes URLs for names, too, but none that begin with a slash.
  const std::string input = std::filesystem::absolute(arguments.input).string();
  const Format format = format_of(input);
  if (format == Format::other) return import_other(input, arguments);
  if (format == Format::hdf5) {
    check_outside_files(input);
  } else {
    check_classic_size(input);
  }
  const NetcdfFile file(input);
  const Grid grid = find_grid(file.root(), arguments.choice);
  if (!grid.crs.empty()) say("crs", grid.crs);
  if (grid.is_in_plain_degrees) say("degrees", "");
  if (grid.is_point.value_or(false)) say("points", "");
  const Variable& variable = grid.variable;
  for (const std::string& note : grid.notes) say("note", note);
  const std::string positive = text_attribute(variable.group, variable.id, "positive");
  if (::strcasecmp(positive.c_str(), "down") == 0)
    say("note", variable.name + " grows downwards, as the file says, and is read as it is");
  copy_grid(grid, arguments.choice, std::filesystem::file_size(input), arguments.output,
            Reporter());
}

/// No life after lode's: not even if it was over before this could say so.
bool is_wanted() {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  pollfd output{.fd = STDOUT_FILENO, .events = 0, .revents = 0};
  return ::poll(&output, 1, 0) <= 0 || (output.revents & POLLERR) == 0;
}

int run(const Arguments& arguments) {
  try {
    set_up_libraries();
    limit_self();
    import(arguments);
    return 0;
  } catch (const std::bad_alloc&) {
    say("error",
        "expected a file that takes up to 2 GiB of memory to be read, got one that wants "
        "more");
  } catch (const std::exception& error) {
    say("error", error.what());
  }
  return kFailure;
}

}  // namespace
}  // namespace lode::raster_import

int main(int argc, char** argv) {
  using namespace lode::raster_import;
  if (!is_wanted()) return kFailure;
  if (argc == 2 && std::string(argv[1]) == "--help") {
    std::fputs(kHelp, stdout);
    return 0;
  }
  const auto arguments = parse_arguments(argc, argv);
  if (arguments) return run(*arguments);
  std::fputs(kHelp, stderr);
  return kUsage;
}
