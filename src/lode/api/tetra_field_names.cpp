// Which of a mesh's fields a name and a time stand for.

#include <fmt/format.h>

#include <algorithm>

#include "lode/api/tetra_dataset.h"

namespace lode {
namespace {

std::string list_fields(const TetraInfo& info) {
  constexpr std::size_t kMost = 20;
  std::string names;
  for (std::size_t i = 0; i < std::min(info.fields.size(), kMost); ++i) {
    const TetraFieldInfo& field = info.fields[i];
    names += fmt::format("{}{}", i > 0 ? ", " : "", field.name);
    if (field.time) names += fmt::format(" at {}", *field.time);
  }
  return names + (info.fields.size() > kMost ? ", ..." : "");
}

}  // namespace

Result<std::size_t> find_field(const TetraInfo& info, const std::string& name,
                               const std::optional<double>& time) {
  const auto found = std::ranges::find_if(info.fields, [&](const TetraFieldInfo& field) {
    return (name.empty() || field.name == name) && (!time || field.time == time);
  });
  if (found != info.fields.end()) return static_cast<std::size_t>(found - info.fields.begin());
  return fail("expected one of the fields {}, got {}{}", list_fields(info),
              name.empty() ? "any" : "'" + name + "'",
              time ? fmt::format(" at the time {}", *time) : "");
}

std::vector<std::size_t> fields_along(const TetraInfo& info, std::size_t field) {
  std::vector<std::size_t> along;
  for (std::size_t i = 0; i < info.fields.size(); ++i) {
    const TetraFieldInfo& other = info.fields[i];
    const bool is_known = !other.time || other.time == info.fields[field].time;
    const bool is_named_alike = other.name == info.fields[field].name;
    if (i != field && is_known && !is_named_alike) along.push_back(i);
  }
  return along;
}

}  // namespace lode
