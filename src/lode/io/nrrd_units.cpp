#include "lode/io/nrrd_units.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "lode/io/text.h"

namespace lode::io {
namespace {

const std::string* find_text(const NrrdFields& fields, const char* key) {
  const auto it = fields.find(key);
  return it == fields.end() ? nullptr : &it->second;
}

/// What headers say of no unit.
bool is_none(std::string_view unit) {
  return unit.empty() || unit == "???" || equals_ignoring_case(unit, "none");
}

/// The one unit among these, beside none; empty where they differ.
std::string common_unit(const std::vector<std::string>& units, std::string& note) {
  std::string common;
  bool is_one = true;
  for (const std::string& unit : units) {
    if (is_none(unit)) continue;
    is_one = is_one && (common.empty() || unit == common);
    common = unit;
  }
  if (is_one) return common;
  std::vector<std::string> shown;
  shown.reserve(units.size());
  for (const std::string& unit : units) shown.push_back(in_quotes(unit));
  note += fmt::format("; axes of different units: {}", fmt::join(shown, ", "));
  return {};
}

}  // namespace

std::optional<std::vector<std::string>> split_quoted(std::string_view list) {
  std::vector<std::string> texts;
  std::size_t at = 0;
  while (true) {
    while (at < list.size() && (list[at] == ' ' || list[at] == '\t')) ++at;
    if (at == list.size()) return texts;
    if (list[at++] != '"') return std::nullopt;
    std::string text;
    while (at < list.size() && list[at] != '"') {
      if (list[at] == '\\' && at + 1 < list.size()) ++at;
      text += list[at++];
    }
    if (at++ == list.size()) return std::nullopt;
    texts.emplace_back(trimmed(text));
  }
}

std::string nrrd_length_unit(const NrrdFields& fields, const std::vector<bool>& is_spatial,
                             std::string& note) {
  const auto n_spatial =
      static_cast<std::size_t>(std::count(is_spatial.begin(), is_spatial.end(), true));
  if (const std::string* text = find_text(fields, "space units")) {
    const auto units = split_quoted(*text);
    const bool has_any = units && std::any_of(units->begin(), units->end(),
                                              [](const auto& unit) { return !is_none(unit); });
    if (has_any && units->size() >= n_spatial) return common_unit(*units, note);
  }
  const std::string* text = find_text(fields, "units");
  if (text == nullptr) return {};
  const auto units = split_quoted(*text);
  if (!units || units->size() != is_spatial.size()) return {};
  std::vector<std::string> spatial;
  for (std::size_t i = 0; i < is_spatial.size(); ++i)
    if (is_spatial[i]) spatial.push_back((*units)[i]);
  return common_unit(spatial, note);
}

std::string nrrd_value_unit(const NrrdFields& fields) {
  const std::string* text = find_text(fields, "sample units");
  if (text == nullptr) return {};
  const auto quoted_texts = split_quoted(*text);
  std::string unit(trimmed(*text));
  if (quoted_texts) unit = quoted_texts->size() == 1 ? quoted_texts->front() : std::string();
  return is_none(unit) ? std::string() : unit;
}

}  // namespace lode::io
