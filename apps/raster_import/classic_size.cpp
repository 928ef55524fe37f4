#include "classic_size.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace lode::raster_import {
namespace {

constexpr std::uint64_t kPadding = 4;

std::uint64_t padded(std::uint64_t n) { return (n + kPadding - 1) / kPadding * kPadding; }

[[noreturn]] void refuse() {
  throw std::runtime_error("expected a netCDF file that is whole, got a header that is damaged");
}

/// A product that would not fit is far more than any file has.
std::uint64_t times(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 62;
  return b != 0 && a > kMost / b ? kMost : a * b;
}

/// Of the types 1 to 11; those from 7 on are CDF-5's.
std::uint64_t size_of_type(std::uint64_t type) {
  constexpr std::array<std::uint64_t, 12> kSizes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
  if (type == 0 || type >= kSizes.size()) refuse();
  return kSizes[type];
}

struct Extent {
  std::uint64_t begin = 0;
  std::uint64_t n_bytes = 0;  ///< Of a record, where it has records.
  bool has_records = false;
};

class ClassicHeader {
 public:
  explicit ClassicHeader(const std::string& path)
      : n_file_(std::filesystem::file_size(path)), file_(path, std::ios::binary) {}

  void read() {
    std::array<char, 4> magic{};
    if (!file_.read(magic.data(), magic.size())) refuse();
    version_ = static_cast<unsigned char>(magic[3]);
    n_records_ = count();
    is_streamed_ = n_records_ == (version_ == 5 ? ~std::uint64_t{0} : 0xFFFFFFFFU);
    const std::uint64_t n_dimensions = list(10);
    for (std::uint64_t i = 0; i < n_dimensions; ++i) {
      skip_name();
      dimensions_.push_back(count());
    }
    skip_attributes();
    const std::uint64_t n_variables = list(11);
    for (std::uint64_t i = 0; i < n_variables; ++i) variables_.push_back(variable());
  }
  void check() const {
    std::uint64_t n_record = 0;
    std::uint64_t n_of_records = 0;
    for (const Extent& one : variables_)
      if (one.has_records) n_record += padded(one.n_bytes), ++n_of_records;
    for (const Extent& one : variables_) {
      // A single variable's records are not padded.
      const std::uint64_t n_stride = n_of_records == 1 ? one.n_bytes : n_record;
      std::uint64_t n = one.n_bytes;
      if (one.has_records && !is_streamed_)
        n = n_records_ == 0 ? 0 : times(n_stride, n_records_ - 1) + one.n_bytes;
      if (n > n_file_ || one.begin > n_file_ - n)
        throw std::runtime_error("expected a netCDF file that is whole, got " +
                                 std::to_string(n_file_) +
                                 " bytes, of which a variable begins at " +
                                 std::to_string(one.begin) + " and has " + std::to_string(n));
    }
  }

 private:
  std::uint64_t number(int n_bytes) {
    std::uint64_t value = 0;
    for (int i = 0; i < n_bytes; ++i) {
      const int byte = file_.get();
      if (byte < 0) refuse();
      value = value << 8U | static_cast<std::uint64_t>(byte);
    }
    return value;
  }
  std::uint64_t count() { return number(version_ == 5 ? 8 : 4); }
  void skip(std::uint64_t n) {
    if (n > n_file_) refuse();
    file_.seekg(static_cast<std::streamoff>(n), std::ios::cur);
    if (static_cast<std::uint64_t>(file_.tellg()) > n_file_) refuse();
  }
  void skip_name() { skip(padded(count())); }
  /// How many follow; 0 where the list is absent.
  std::uint64_t list(std::uint64_t tag) {
    const std::uint64_t found = number(4);
    const std::uint64_t n = count();
    if ((found != tag && (found != 0 || n != 0)) || n > n_file_) refuse();
    return n;
  }
  void skip_attributes() {
    const std::uint64_t n = list(12);
    for (std::uint64_t i = 0; i < n; ++i) {
      skip_name();
      const std::uint64_t size = size_of_type(number(4));
      skip(padded(times(count(), size)));
    }
  }
  Extent variable() {
    skip_name();
    const std::uint64_t rank = count();
    if (rank > n_file_) refuse();
    Extent extent{.n_bytes = 1};
    for (std::uint64_t i = 0; i < rank; ++i) {
      const std::uint64_t id = count();
      if (id >= dimensions_.size()) refuse();
      if (dimensions_[id] == 0 && i == 0) {
        extent.has_records = true;
      } else {
        extent.n_bytes = times(extent.n_bytes, dimensions_[id]);
      }
    }
    skip_attributes();
    extent.n_bytes = times(extent.n_bytes, size_of_type(number(4)));
    count();  // which says no more, and cannot of what is large
    extent.begin = number(version_ == 1 ? 4 : 8);
    return extent;
  }

  std::uint64_t n_file_;
  std::ifstream file_;
  int version_ = 0;
  std::uint64_t n_records_ = 0;
  bool is_streamed_ = false;
  std::vector<std::uint64_t> dimensions_;
  std::vector<Extent> variables_;
};

}  // namespace

void check_classic_size(const std::string& path) {
  ClassicHeader header(path);
  header.read();
  header.check();
}

}  // namespace lode::raster_import
