#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "lode/io/surface_output.h"

namespace lode::io {

/// Types of netCDF's classic formats, by their numbers.
enum class NetcdfType : std::uint8_t { text = 2, int32 = 4, float32 = 5, float64 = 6 };

struct NetcdfDimension {
  std::string name;
  std::uint32_t length = 0;  ///< 0: of the records, of which there is one. Others have no 0.
};

struct NetcdfAttribute {
  std::string name;
  std::variant<std::string, std::int32_t, float> value;
};

struct NetcdfVariable {
  std::string name;
  NetcdfType type = NetcdfType::float64;
  std::vector<std::uint32_t> dimensions{};  ///< Places of; that of the records comes first.
  std::vector<NetcdfAttribute> attributes{};
  std::size_t n_rows = 0;  ///< In which its numbers are filled in, all of one length.
  /// Puts the numbers of a row, most significant byte first, or characters.
  std::function<void(std::size_t row, std::byte* out)> fill{};
};

/// What a netCDF file holds.
struct NetcdfContent {
  std::vector<NetcdfDimension> dimensions{};
  std::vector<NetcdfAttribute> attributes{};
  std::vector<NetcdfVariable> variables{};
};

/// Bytes of all variables together.
[[nodiscard]] std::uint64_t netcdf_data_bytes(const NetcdfContent& content);

/// Appends a file of the classic format with 64-bit offsets (CDF-2), as the NetCDF Classic Format
/// Specification of Unidata has it. Fails, naming `path`, where a variable takes 4 GiB or more,
/// which that format cannot hold.
[[nodiscard]] Result<void> write_netcdf(const std::string& path, const NetcdfContent& content,
                                        SurfaceOutput& file);

}  // namespace lode::io
