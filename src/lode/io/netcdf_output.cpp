#include "lode/io/netcdf_output.h"

#include <limits>

#include "lode/io/mesh_blocks.h"

namespace lode::io {
namespace {

constexpr std::uint32_t kDimensions = 10;
constexpr std::uint32_t kVariables = 11;
constexpr std::uint32_t kAttributes = 12;

/// The header being made: big-endian numbers, and names that fill words.
struct NetcdfHeader {
  std::vector<std::byte> bytes;

  template <typename T>
  void number(T value) {
    bytes.resize(bytes.size() + sizeof(T));
    std::byte* out = bytes.data() + bytes.size() - sizeof(T);
    put_big(out, value);
  }
  void characters(std::string_view text) {
    const auto all = std::as_bytes(std::span(text.data(), text.size()));
    bytes.insert(bytes.end(), all.begin(), all.end());
    bytes.resize((bytes.size() + 3) / 4 * 4);
  }
  void name(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    characters(text);
  }
  /// A list's kind and length; both 0 where it is empty.
  void list(std::uint32_t kind, std::size_t n) {
    number(n == 0 ? 0 : kind);
    number(static_cast<std::uint32_t>(n));
  }
  void attribute(const NetcdfAttribute& attribute);
  void attributes(const std::vector<NetcdfAttribute>& all) {
    list(kAttributes, all.size());
    for (const NetcdfAttribute& one : all) attribute(one);
  }
};

void NetcdfHeader::attribute(const NetcdfAttribute& attribute) {
  name(attribute.name);
  if (const auto* const text = std::get_if<std::string>(&attribute.value)) {
    number(static_cast<std::uint32_t>(NetcdfType::text));
    name(*text);
  } else if (const auto* const whole = std::get_if<std::int32_t>(&attribute.value)) {
    number(static_cast<std::uint32_t>(NetcdfType::int32));
    number(std::uint32_t{1});
    number(*whole);
  } else {
    number(static_cast<std::uint32_t>(NetcdfType::float32));
    number(std::uint32_t{1});
    number(std::get<float>(attribute.value));
  }
}

bool is_record(const NetcdfContent& content, const NetcdfVariable& variable) {
  return !variable.dimensions.empty() &&
         content.dimensions[variable.dimensions.front()].length == 0;
}

std::uint64_t size_of(NetcdfType type) {
  if (type == NetcdfType::text) return 1;
  return type == NetcdfType::float64 ? 8 : 4;
}

std::uint64_t bytes_of(const NetcdfContent& content, const NetcdfVariable& variable) {
  std::uint64_t n = size_of(variable.type);
  for (const std::uint32_t dimension : variable.dimensions)
    n *= std::max(content.dimensions[dimension].length, 1U);
  return n;
}

std::uint64_t padded(std::uint64_t n_bytes) { return (n_bytes + 3) / 4 * 4; }

/// `begins`: of variables' data, in the order of the variables.
NetcdfHeader make_header(const NetcdfContent& content, const std::vector<std::uint64_t>& begins) {
  NetcdfHeader header;
  header.characters("CDF\x02");
  header.number(std::uint32_t{1});
  header.list(kDimensions, content.dimensions.size());
  for (const NetcdfDimension& dimension : content.dimensions) {
    header.name(dimension.name);
    header.number(dimension.length);
  }
  header.attributes(content.attributes);
  header.list(kVariables, content.variables.size());
  for (std::size_t i = 0; i < content.variables.size(); ++i) {
    const NetcdfVariable& variable = content.variables[i];
    header.name(variable.name);
    header.number(static_cast<std::uint32_t>(variable.dimensions.size()));
    for (const std::uint32_t dimension : variable.dimensions) header.number(dimension);
    header.attributes(variable.attributes);
    header.number(static_cast<std::uint32_t>(variable.type));
    header.number(static_cast<std::uint32_t>(padded(bytes_of(content, variable))));
    header.number(begins[i]);
  }
  return header;
}

/// Variables of records come after all others.
std::vector<std::size_t> data_order(const NetcdfContent& content) {
  std::vector<std::size_t> order;
  for (const bool of_records : {false, true})
    for (std::size_t i = 0; i < content.variables.size(); ++i)
      if (is_record(content, content.variables[i]) == of_records) order.push_back(i);
  return order;
}

Result<void> write_variable(const NetcdfContent& content, const NetcdfVariable& variable,
                            SurfaceOutput& file) {
  const std::uint64_t n_bytes = bytes_of(content, variable);
  LODE_EXPECTS(variable.n_rows > 0 && n_bytes % variable.n_rows == 0);
  LODE_CHECK(write_records(file, variable.n_rows, n_bytes / variable.n_rows, variable.fill));
  return file.write(std::string_view("\0\0\0", padded(n_bytes) - n_bytes));
}

}  // namespace

std::uint64_t netcdf_data_bytes(const NetcdfContent& content) {
  std::uint64_t n = 0;
  for (const NetcdfVariable& variable : content.variables) n += padded(bytes_of(content, variable));
  return n;
}

Result<void> write_netcdf(const std::string& path, const NetcdfContent& content,
                          SurfaceOutput& file) {
  constexpr std::uint64_t kMaxBytes = std::numeric_limits<std::uint32_t>::max() - 3;
  for (const NetcdfVariable& variable : content.variables)
    if (bytes_of(content, variable) >= kMaxBytes)
      return fail("{}: expected less than 4 GiB of {}, as netCDF's classic format can hold, got {}",
                  path, variable.name, bytes_of(content, variable));
  const std::vector<std::size_t> order = data_order(content);
  // Begins take as many bytes whatever they are.
  std::vector<std::uint64_t> begins(content.variables.size());
  std::uint64_t begin = make_header(content, begins).bytes.size();
  for (const std::size_t i : order) {
    begins[i] = begin;
    begin += padded(bytes_of(content, content.variables[i]));
  }
  LODE_CHECK(file.write(make_header(content, begins).bytes));
  for (const std::size_t i : order) LODE_CHECK(write_variable(content, content.variables[i], file));
  return {};
}

}  // namespace lode::io
