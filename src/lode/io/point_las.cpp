#include "lode/io/point_las.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>

#include "lode/io/input_file.h"
#include "lode/io/las_crs.h"
#include "lode/io/little_endian.h"

namespace lode::io {
namespace {

constexpr std::uint64_t kSmallestHeader = 227;
constexpr std::uint64_t kHeader14 = 375;
constexpr int kMostFormats = 11;
constexpr std::array<std::uint16_t, kMostFormats> kRecordBytes{20, 28, 26, 34, 57, 63,
                                                               30, 36, 38, 59, 67};

struct LasHeader {
  int major = 1;
  int minor = 0;
  int format = 0;
  std::uint16_t n_record_bytes = 0;
  std::uint64_t n_points = 0;
  std::uint64_t first_point = 0;  ///< Bytes from the file's start.
  std::array<double, 3> scale{};
  std::array<double, 3> offset{};
  LasRecords records;

  [[nodiscard]] bool has_new_flags() const { return format >= 6; }
};

Result<void> check_sizes(const InputFile& file, const LasHeader& header,
                         std::uint16_t n_header_bytes) {
  const std::uint64_t needed = header.minor >= 4 ? kHeader14 : kSmallestHeader;
  if (n_header_bytes < needed || header.first_point < n_header_bytes)
    return fail(
        "{}: expected a header of {} bytes or more and points behind it at offsets 94 and 96, got "
        "{} and {}",
        file.path(), needed, n_header_bytes, header.first_point);
  if (header.n_record_bytes < kRecordBytes[static_cast<std::size_t>(header.format)])
    return fail("{}: expected records of {} bytes or more of format {} at offset 105, got {}",
                file.path(), kRecordBytes[static_cast<std::size_t>(header.format)], header.format,
                header.n_record_bytes);
  if (header.n_points == 0) return fail("{}: expected points, the header says none", file.path());
  if (header.n_points > file.size_from(header.first_point) / header.n_record_bytes)
    return fail("{}: expected {} points of {} bytes from offset {}, got a file of {} bytes",
                file.path(), header.n_points, header.n_record_bytes, header.first_point,
                file.size());
  return {};
}

Result<void> check_scales(const InputFile& file, const LasHeader& header) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!(std::abs(header.scale[i]) >= 1e-100 && std::abs(header.scale[i]) <= 1e100 &&
          std::abs(header.offset[i]) <= 1e100))
      return fail("{}: expected scales and offsets from offset 131, got {} and {} of axis {}",
                  file.path(), header.scale[i], header.offset[i], i);
  return {};
}

Result<void> check_format(const InputFile& file, std::uint8_t format) {
  constexpr std::uint8_t kCompressed = 0xC0;
  if ((format & kCompressed) != 0)
    return fail(
        "{}: expected points that are not compressed, got LAZ (point format {} at offset 104): "
        "unpack it first, as by laszip -i IN.laz -o OUT.las or pdal translate IN.laz OUT.las",
        file.path(), format);
  if (format >= kMostFormats)
    return fail("{}: expected a point format from 0 to {} at offset 104, got {}", file.path(),
                kMostFormats - 1, format);
  return {};
}

Result<LasHeader> read_header(const InputFile& file) {
  std::array<std::byte, kHeader14> bytes{};
  const std::uint64_t n = std::min<std::uint64_t>(file.size(), bytes.size());
  if (n < kSmallestHeader)
    return fail("{}: expected a LAS header of {} bytes or more, got a file of {}", file.path(),
                kSmallestHeader, file.size());
  LODE_CHECK(file.read(0, std::span(bytes).first(static_cast<std::size_t>(n))));
  const LittleEndian at(bytes);
  if (at.text(0, 4) != "LASF")
    return fail("{}: expected 'LASF' at offset 0, as LAS files begin, got other bytes",
                file.path());
  LasHeader header;
  header.major = at.u8(24);
  header.minor = at.u8(25);
  if (header.major != 1 || header.minor > 4)
    return fail("{}: expected LAS 1.0 to 1.4 at offset 24, got {}.{}", file.path(), header.major,
                header.minor);
  LODE_CHECK(check_format(file, at.u8(104)));
  header.format = at.u8(104);
  header.first_point = at.u32(96);
  header.n_record_bytes = at.u16(105);
  header.n_points = at.u32(107);
  header.records = {.first = at.u16(94), .n = at.u32(100), .end = header.first_point};
  for (std::size_t i = 0; i < 3; ++i) {
    header.scale[i] = at.f64(131 + 8 * i);
    header.offset[i] = at.f64(155 + 8 * i);
  }
  if (header.minor >= 4) {
    // Whole only where the file is long enough; check_sizes() refuses others.
    if (at.u64(247) > 0) header.n_points = at.u64(247);
    header.records.first_extended = at.u64(235);
    header.records.n_extended = at.u32(243);
  }
  LODE_CHECK(check_sizes(file, header, at.u16(94)));
  LODE_CHECK(check_scales(file, header));
  return header;
}

class LasPointReader {
 public:
  LasPointReader(const InputFile& file, const LasHeader& header, const PointReadOptions& options)
      : file_(file), header_(header), options_(options) {
    is_kept_.fill(options.classes.empty());
    for (const std::uint8_t one : options.classes) is_kept_[one] = true;
  }

  Result<void> read(PointFile& read, Progress& progress) const {
    constexpr std::uint64_t kAtOnce = 1 << 14;
    std::vector<std::byte> bytes;
    const std::uint64_t n_record = header_.n_record_bytes;
    for (std::uint64_t first = 0; first < header_.n_points; first += kAtOnce) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("reading",
                      static_cast<double>(first) / static_cast<double>(header_.n_points));
      const std::uint64_t n = std::min(kAtOnce, header_.n_points - first);
      bytes.resize(static_cast<std::size_t>(n * n_record));
      LODE_CHECK(file_.read(header_.first_point + first * n_record, bytes));
      for (std::uint64_t i = 0; i < n; ++i)
        add(LittleEndian(std::span(bytes).subspan(static_cast<std::size_t>(i * n_record))), read);
    }
    read.counts.n_in_file = header_.n_points;
    return {};
  }

 private:
  struct Flags {
    std::uint8_t of_class;
    bool is_synthetic;
    bool is_withheld;
  };
  [[nodiscard]] Flags flags_of(const LittleEndian& record) const {
    const std::uint8_t flags = record.u8(15);
    if (header_.has_new_flags()) return {record.u8(16), (flags & 1) != 0, (flags & 4) != 0};
    return {static_cast<std::uint8_t>(flags & 0x1F), (flags & 0x20) != 0, (flags & 0x80) != 0};
  }
  void add(const LittleEndian& record, PointFile& read) const {
    const Flags flags = flags_of(record);
    PointCounts& counts = read.counts;
    ++counts.of_class[flags.of_class];
    if (flags.is_withheld) {
      ++counts.n_withheld;
      return;
    }
    if (!is_kept_[flags.of_class]) {
      ++counts.n_other_class;
      return;
    }
    Vec3d point;
    for (std::size_t i = 0; i < 3; ++i)
      point[i] = record.i32(4 * i) * header_.scale[i] + header_.offset[i];
    if (options_.nodata && point[2] == *options_.nodata) {
      ++counts.n_missing;
      return;
    }
    counts.n_synthetic += static_cast<std::uint64_t>(flags.is_synthetic);
    read.points.push_back(point);
  }

  const InputFile& file_;
  const LasHeader& header_;
  const PointReadOptions& options_;
  std::array<bool, 256> is_kept_{};
};

}  // namespace

Result<PointFile> read_las(const std::string& path, const PointReadOptions& options,
                           Progress& progress) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  LODE_TRY(const LasHeader header, read_header(*file));
  PointFile read;
  read.format = fmt::format("LAS {}.{}, format {}", header.major, header.minor, header.format);
  if (header.scale[0] == header.scale[1])
    read.lattice = {{header.offset[0], header.offset[1]}, std::abs(header.scale[0])};
  LODE_TRY(const LasCrs crs,
           read_las_crs(*file, header.records,
                        options.crs.empty() ? LasCrsUse::wanted : LasCrsUse::ignored));
  read.crs = crs.wkt;
  read.crs_note = crs.note;
  read.vertical_unit = crs.vertical_unit;
  LODE_CHECK(LasPointReader(*file, header, options).read(read, progress));
  return read;
}

}  // namespace lode::io
