#include "tetra_field_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "parse.h"

namespace lode::cli {
namespace {

constexpr std::string_view kAt = " at ";
/// With --with: all others.
constexpr std::string_view kAllFields = "all";

/// "NAME at TIME": the name, and the rest, which is empty where there is none.
struct TimedName {
  std::string name;
  std::string rest;
  std::optional<double> time{};
};

TimedName split_time(const std::string& text) {
  const std::size_t at = text.rfind(kAt);
  if (at == std::string::npos) return {text, ""};
  const auto time = parse_number("", text.substr(at + kAt.size()));
  return time ? TimedName{text.substr(0, at), text.substr(at), *time} : TimedName{text, ""};
}

/// A field that is asked for, perhaps with its time behind it as lists of fields have it.
struct NamedField {
  std::string name;
  std::optional<double> time{};
  std::vector<std::size_t> steps{};  ///< Places, in order of time; what has none comes first.
};

NamedField steps_of(const TetraInfo& info, std::string name, std::optional<double> time) {
  NamedField field{std::move(name), time};
  for (std::size_t i = 0; i < info.fields.size(); ++i)
    if (info.fields[i].name == field.name) field.steps.push_back(i);
  std::ranges::stable_sort(field.steps, {}, [&](std::size_t i) { return info.fields[i].time; });
  return field;
}

Result<NamedField> to_named_field(const TetraInfo& info, const std::string& text) {
  const std::string whole = text.empty() ? info.fields[0].name : text;
  const TimedName timed = split_time(whole);
  for (const std::string& name : {whole, numbered_component(whole)})
    if (NamedField field = steps_of(info, name, {}); !field.steps.empty()) return field;
  for (const std::string& name : {timed.name, numbered_component(timed.name)})
    if (NamedField field = steps_of(info, name, timed.time); !field.steps.empty()) return field;
  LODE_CHECK(find_field(info, text));  // Names those that there are.
  return fail("expected a field, got '{}'", text);
}

bool has_times(const TetraInfo& info, const NamedField& field) {
  return info.fields[field.steps.back()].time.has_value();
}

std::string text_of(const std::optional<double>& time) {
  return time ? fmt::format("at {}", *time) : "without a time";
}

/// The place of a field that has steps at a time, or among those without one.
Result<std::size_t> step_at(const TetraInfo& info, const NamedField& field,
                            const std::optional<double>& time) {
  constexpr std::size_t kMostNamed = 20;
  std::string times;
  for (std::size_t i = 0; i < field.steps.size(); ++i) {
    const std::optional<double>& other = info.fields[field.steps[i]].time;
    if (other == time && (!field.time || field.time == time)) return field.steps[i];
    if (i < kMostNamed) times += (i > 0 ? ", " : "") + text_of(other);
  }
  if (field.steps.size() > kMostNamed) times += ", ...";
  return fail("field {}: expected a step {}, as all fields of an answer are of one time, got {}",
              field.name, text_of(time),
              field.time && field.time != time ? "one " + text_of(field.time) : times);
}

/// The time of the first field, by its name or as the step of a number.
Result<std::optional<double>> time_of(const TetraInfo& info, const NamedField& field,
                                      const std::string& step) {
  if (field.time && !step.empty())
    return fail("--time: expected none with the field {} {}, got {}", field.name,
                text_of(field.time), step);
  if (field.time) return field.time;
  if (step.empty()) return info.fields[field.steps.front()].time;
  LODE_TRY(const std::int64_t n,
           parse_integer("--time", step, 0, static_cast<std::int64_t>(field.steps.size()) - 1));
  return info.fields[field.steps[static_cast<std::size_t>(n)]].time;
}

/// Names of a vector's components that are fields, or why there are none.
Result<std::vector<std::string>> vector_names(const TetraInfo& info,
                                              const ReadingArguments& reading) {
  const IsField is_field = is_field_of(info);
  std::vector<std::string> names;
  for (const std::string& component : reading.deforming)
    for (std::string& name : scalars_of(component, is_field)) names.push_back(std::move(name));
  for (const std::string& name : names) {
    if (is_field(name) || is_field(split_time(name).name)) continue;
    std::vector<std::string> fields;
    for (const TetraFieldInfo& field : info.fields)
      if (std::ranges::find(fields, field.name) == fields.end()) fields.push_back(field.name);
    return fail(
        "--warp: expected a vector, whose three components are fields of their own (build --with "
        "NAME:xyz), but there is no {} among {}",
        name, fmt::join(fields, ", "));
  }
  return names;
}

WarpPlaces warp_places(std::span<const std::size_t> asked, std::span<const std::size_t> vector) {
  WarpPlaces warp;
  std::ranges::copy(vector, warp.vector.begin());
  for (const std::size_t place : vector)
    if (std::ranges::find(asked, place) == asked.end()) warp.hidden.push_back(place);
  return warp;
}

}  // namespace

IsField is_field_of(const TetraInfo& info) {
  return [&info](const std::string& name) {
    return std::ranges::find(info.fields, name, &TetraFieldInfo::name) != info.fields.end();
  };
}

std::string numbered_component(const std::string& text) {
  const TimedName timed = split_time(text);
  const std::string& name = timed.name;
  if (name.size() < 3 || name[name.size() - 2] != ':') return text;
  const std::size_t axis = std::string_view("xyz").find(name.back());
  if (axis == std::string_view::npos) return text;
  return name.substr(0, name.size() - 1) + std::to_string(axis) + timed.rest;
}

std::vector<std::string> scalars_of(const std::string& name, const IsField& is_field) {
  const TimedName timed = split_time(name);
  if (is_field && (is_field(name) || is_field(timed.name))) return {name};
  if (!timed.name.ends_with(kVectorEnd)) return {numbered_component(name)};
  const std::string vector = timed.name.substr(0, timed.name.size() - kVectorEnd.size());
  return {vector + ":0" + timed.rest, vector + ":1" + timed.rest, vector + ":2" + timed.rest};
}

bool wants_all(const ReadingArguments& reading) {
  return std::ranges::find(reading.with, kAllFields) != reading.with.end();
}

std::vector<std::string> scalars_of_with(const ReadingArguments& reading, const IsField& is_field) {
  std::vector<std::string> names;
  for (const std::string& name : reading.with)
    if (name != kAllFields)
      for (std::string& scalar : scalars_of(name, is_field)) names.push_back(std::move(scalar));
  return names;
}

Result<std::vector<std::size_t>> named_fields(const TetraInfo& info,
                                              const std::vector<std::string>& names,
                                              const std::string& step) {
  std::vector<NamedField> fields;
  for (const std::string& name : names) {
    LODE_TRY(NamedField field, to_named_field(info, name));
    fields.push_back(std::move(field));
  }
  const auto first =
      std::ranges::find_if(fields, [&](const NamedField& field) { return has_times(info, field); });
  if (first == fields.end() && !step.empty())
    return fail("--time: expected none, as the field {} has no steps, got {}", fields[0].name,
                step);
  std::optional<double> time;
  if (first != fields.end()) {
    LODE_TRY(time, time_of(info, *first, step));
  }
  std::vector<std::size_t> places;
  for (const NamedField& field : fields) {
    const bool is_of_all_times = !has_times(info, field) && !field.time;
    LODE_TRY(const std::size_t at, is_of_all_times ? Result<std::size_t>(field.steps.front())
                                                   : step_at(info, field, time));
    places.push_back(at);
  }
  return places;
}

Result<ReadFields> fields_of(const TetraInfo& info, const ReadingArguments& reading) {
  const IsField is_field = is_field_of(info);
  std::vector<std::string> names = scalars_of(reading.field, is_field);
  for (std::string& name : scalars_of_with(reading, is_field)) names.push_back(std::move(name));
  if (wants_all(reading))
    for (const TetraFieldInfo& field : info.fields)
      if (std::ranges::find(names, field.name) == names.end()) names.push_back(field.name);
  const std::size_t n_asked = names.size();
  LODE_TRY(const std::vector<std::string> vector, vector_names(info, reading));
  names.insert(names.end(), vector.begin(), vector.end());
  LODE_TRY(const std::vector<std::size_t> places, named_fields(info, names, reading.time));
  ReadFields fields{.use = {.measured = places[0]}};
  TetraFieldUse& use = fields.use;
  for (const std::size_t at : places)
    if (at != use.measured && std::ranges::find(use.along, at) == use.along.end())
      use.along.push_back(at);
  if (!vector.empty())
    fields.warp = warp_places(std::span(places).first(n_asked), std::span(places).subspan(n_asked));
  return fields;
}

Result<ReadFields> fields_of_built(const TetraInfo& info, const ReadingArguments& reading) {
  ReadFields fields;
  for (std::size_t i = 1; i < info.fields.size(); ++i) fields.use.along.push_back(i);
  if (reading.deforming.empty()) return fields;
  const IsField is_field = is_field_of(info);
  LODE_TRY(const std::vector<std::string> vector, vector_names(info, reading));
  std::vector<std::string> names = scalars_of_with(reading, is_field);
  if (wants_all(reading))
    for (const TetraFieldInfo& field : info.fields) names.push_back(field.name);
  std::vector<std::size_t> asked{0};
  for (const std::string& name : names)
    for (std::size_t i = 1; i < info.fields.size(); ++i)
      if (info.fields[i].name == name) asked.push_back(i);
  std::vector<std::size_t> places;
  for (const std::string& name : vector)
    for (std::size_t i = 0; i < info.fields.size(); ++i)
      if (info.fields[i].name == name && places.size() < 3) places.push_back(i);
  fields.warp = warp_places(asked, places);
  return fields;
}

}  // namespace lode::cli
