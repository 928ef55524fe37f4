#include "netcdf_file.h"

#include <algorithm>
#include <array>
#include <new>
#include <stdexcept>

namespace lode::raster_import {
namespace {

constexpr std::size_t kMostAttributeBytes = std::size_t{1} << 20;
constexpr int kMostDepth = 32;

std::string trimmed(std::string text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\0' || c == '\n' || c == '\r'; };
  while (!text.empty() && is_blank(text.back())) text.pop_back();
  const auto first = std::find_if_not(text.begin(), text.end(), is_blank);
  return {first, text.end()};
}

void add_variables(int group, const std::string& prefix, int depth, std::vector<Variable>& all) {
  if (depth > kMostDepth) throw std::runtime_error("expected groups in groups up to 32 deep");
  int n = 0;
  check(nc_inq_varids(group, &n, nullptr), "variables");
  std::vector<int> ids(static_cast<std::size_t>(n));
  check(nc_inq_varids(group, &n, ids.data()), "variables");
  for (const int id : ids) {
    std::array<char, NC_MAX_NAME + 1> name{};
    Variable variable{.group = group, .id = id};
    int rank = 0;
    check(nc_inq_varndims(group, id, &rank), "variables");
    variable.dimensions.resize(static_cast<std::size_t>(rank));
    check(nc_inq_var(group, id, name.data(), &variable.type, nullptr, variable.dimensions.data(),
                     nullptr),
          "variables");
    variable.name = prefix + name.data();
    all.push_back(std::move(variable));
  }
  check(nc_inq_grps(group, &n, nullptr), "groups");
  std::vector<int> groups(static_cast<std::size_t>(n));
  check(nc_inq_grps(group, &n, groups.data()), "groups");
  for (const int inner : groups) {
    std::array<char, NC_MAX_NAME + 1> name{};
    check(nc_inq_grpname(inner, name.data()), "groups");
    add_variables(inner, prefix + name.data() + "/", depth + 1, all);
  }
}

}  // namespace

void check(int status, const std::string& what) {
  if (status == NC_NOERR) return;
  if (status == NC_ENOMEM) throw std::bad_alloc();
  throw std::runtime_error("expected " + what + ", got: " + nc_strerror(status));
}

NetcdfFile::NetcdfFile(const std::string& path) {
  const int status = nc_open(path.c_str(), NC_NOWRITE, &id_);
  if (status == NC_ENOMEM) throw std::bad_alloc();
  if (status != NC_NOERR)
    throw std::runtime_error(std::string("expected a netCDF file that is whole, got: ") +
                             nc_strerror(status));
}

NetcdfFile::~NetcdfFile() { nc_close(id_); }

std::vector<Variable> all_variables(int root) {
  std::vector<Variable> all;
  add_variables(root, "", 0, all);
  return all;
}

std::size_t length_of(int group, int dimension) {
  std::size_t length = 0;
  check(nc_inq_dimlen(group, dimension, &length), "a dimension");
  return length;
}

std::string dimension_name(int group, int dimension) {
  std::array<char, NC_MAX_NAME + 1> name{};
  check(nc_inq_dimname(group, dimension, name.data()), "a dimension");
  return name.data();
}

AttributeShape attribute_shape(int group, int variable, const char* name) {
  AttributeShape shape;
  const int status = nc_inq_att(group, variable, name, &shape.type, &shape.n);
  if (status == NC_ENOTATT) return {};
  check(status, std::string("the attribute ") + name);
  if (shape.n > kMostAttributeBytes)
    throw std::runtime_error(std::string("expected up to 1 MiB of the attribute ") + name);
  return shape;
}

std::string text_attribute(int group, int variable, const char* name) {
  const AttributeShape shape = attribute_shape(group, variable, name);
  if (!shape.is_text() || shape.n == 0) return {};
  const std::string what = std::string("the attribute ") + name;
  if (shape.type == NC_CHAR) {
    std::string text(shape.n, '\0');
    check(nc_get_att_text(group, variable, name, text.data()), what);
    return trimmed(std::move(text));
  }
  std::vector<char*> texts(shape.n, nullptr);
  check(nc_get_att_string(group, variable, name, texts.data()), what);
  const std::string first = texts[0] == nullptr ? "" : texts[0];
  nc_free_string(shape.n, texts.data());
  return trimmed(first);
}

std::vector<double> numbers_attribute(int group, int variable, const char* name) {
  const AttributeShape shape = attribute_shape(group, variable, name);
  if (shape.type == NC_NAT) return {};
  if (shape.is_text())
    throw std::runtime_error(std::string("expected numbers in the attribute ") + name +
                             ", got text");
  std::vector<double> numbers(shape.n);
  check(nc_get_att_double(group, variable, name, numbers.data()),
        std::string("the attribute ") + name);
  return numbers;
}

}  // namespace lode::raster_import
