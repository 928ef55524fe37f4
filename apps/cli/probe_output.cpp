#include "probe_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tetra_input.h"

namespace lode::cli {
namespace {

const char* status_of(const ProbedPoint& point) {
  if (point.is_near_boundary) return "near boundary";
  if (!point.is_inside) return "outside";
  if (point.snapped > 0) return "snapped";
  return point.is_exact ? "exact" : "bounded";
}

using NamedNumber = std::pair<std::string, BoundedNumber>;

/// What an integral says of a field.
template <typename Integral>
std::vector<NamedNumber> numbers_of_field(const Integral& of) {
  return {{"integral", of.integral},
          {"mean", of.mean},
          {"minimum", of.minimum},
          {"maximum", of.maximum}};
}

/// The five numbers of an integral by their names, and four of each further field, "mean of p".
std::vector<NamedNumber> numbers_of(const ProbeAnswer& answer) {
  const IntegralReport& report = *answer.integral;
  std::vector<NamedNumber> numbers{{"volume", report.volume}};
  for (NamedNumber& number : numbers_of_field(report)) numbers.push_back(std::move(number));
  for (std::size_t f = 0; f < report.along.size(); ++f)
    for (const auto& [name, number] : numbers_of_field(report.along[f]))
      numbers.emplace_back(name + " of " + answer.with[f], number);
  return numbers;
}

std::vector<std::string> headings_of(const ProbeAnswer& answer) {
  std::vector<std::string> headings;
  if (!answer.line.empty()) headings = {"part", "distance"};
  headings.insert(headings.end(), {"x", "y", "z", "status", "value", "low", "high", "error"});
  if (answer.has_regions) headings.emplace_back("region");
  for (const std::string& name : answer.with)
    for (const char* const what : {"", " low", " high", " error"}) headings.push_back(name + what);
  return headings;
}

/// `format(number)`: as text.
template <typename Format>
std::vector<std::string> row_of(const ProbedPoint& point, const ProbeAnswer& answer,
                                const Format& format) {
  std::vector<std::string> row;
  for (const double x : point.point.v) row.push_back(format(x));
  row.emplace_back(status_of(point));
  const bool has_bounds = point.is_inside || point.is_near_boundary;
  const auto add = [&](const BoundedNumber& number, double error) {
    row.push_back(point.is_inside ? format(number.value) : "");
    for (const double x : {number.low, number.high}) row.push_back(has_bounds ? format(x) : "");
    row.push_back(point.is_inside ? format(error) : "");
  };
  add(point.value, point.error);
  if (answer.has_regions) row.push_back(point.is_inside ? fmt::format("{}", point.region) : "");
  for (const ProbedValue& more : point.along) add(more.value, more.error);
  return row;
}

/// Calls add(row) for each.
template <typename Format, typename Add>
void visit_rows(const ProbeAnswer& answer, const Format& format, const Add& add) {
  for (const ProbedPoint& point : answer.points) add(row_of(point, answer, format));
  for (const ProbedLinePoint& point : answer.line) {
    std::vector<std::string> row{point.at.is_inside ? fmt::format("{}", point.part) : "",
                                 format(point.distance)};
    for (std::string& text : row_of(point.at, answer, format)) row.push_back(std::move(text));
    add(std::move(row));
  }
}

Json bounded_json(const BoundedNumber& number) {
  return {{"value", number.value}, {"low", number.low}, {"high", number.high}};
}

template <typename Integral>
Json integral_json(const Integral& of, bool is_empty, ErrorPlace place) {
  Json json;
  for (const auto& [name, number] : numbers_of_field(of))
    json[name] = is_empty ? Json(nullptr) : bounded_json(number);
  json["integral_rounding"] = of.integral_rounding;
  const bool is_estimate = place == ErrorPlace::at_samples;
  json[is_estimate ? "integral_error_estimate" : "integral_error"] = of.integral_estimate;
  return json;
}

/// What is said of further fields as a whole; of an integral that is all.
Json with_json(const ProbeAnswer& answer) {
  Json with = Json::array();
  for (std::size_t f = 0; f < answer.with.size(); ++f) {
    const ProbedField& about = answer.report.along[f];
    Json one{{"field", answer.with[f]},
             {"achieved_error", about.achieved_error},
             {"error_kind", name_of(about.error_place)}};
    if (answer.integral)
      one.update(
          integral_json(answer.integral->along[f], answer.integral->is_empty, about.error_place));
    with.push_back(std::move(one));
  }
  return with;
}

/// Of a field at a point: bounds where they are known, and the value inside.
Json value_json(const ProbedPoint& point, const BoundedNumber& value, double error) {
  Json json = Json::object();
  if (point.is_near_boundary) {
    json["low"] = value.low;
    json["high"] = value.high;
  }
  if (!point.is_inside) return json;
  json.update(bounded_json(value));
  json["error"] = error;
  return json;
}

Json point_json(const ProbedPoint& point, const ProbeAnswer& answer) {
  Json json;
  json["point"] = point.point.v;
  json["status"] = status_of(point);
  json.update(value_json(point, point.value, point.error));
  if (point.snapped > 0) json["snapped"] = point.snapped;
  if (point.is_inside && answer.has_regions) json["region"] = point.region;
  for (std::size_t f = 0; f < point.along.size(); ++f) {
    Json more = value_json(point, point.along[f].value, point.along[f].error);
    more["field"] = answer.with[f];
    json["with"].push_back(std::move(more));
  }
  return json;
}

/// As RFC 4180 has it: in quotes where names of fields need it.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

void append_row(std::string& text, const std::vector<std::string>& row) {
  for (std::size_t i = 0; i < row.size(); ++i) text += (i == 0 ? "" : ",") + csv_cell(row[i]);
  text += '\n';
}

std::string exact_number(double x) { return fmt::format("{}", x); }

}  // namespace

void warn_of_answer(Session& session, const ProbeAnswer& answer, bool has_holes) {
  if (answer.integral && answer.integral->is_empty)
    session.warn("the integral is empty: no cell has a part in the region or box");
  if (!answer.points.empty() && answer.report.n_outside > 0)
    session.warn(fmt::format("{} of {} points are outside{}", answer.report.n_outside,
                             answer.points.size(), has_holes ? ", or where a hole is near" : ""));
  if (answer.report.n_near_boundary > 0)
    session.warn(fmt::format(
        "{} of the points are outside of the cut, but no farther than its boundary may be off: "
        "if the field is there, it is from low to high",
        answer.report.n_near_boundary));
  const auto n_snapped = std::ranges::count_if(
      answer.points, [](const ProbedPoint& point) { return point.snapped > 0; });
  if (n_snapped > 0)
    session.note(fmt::format(
        "{} of the points are outside, and have what the nearest point inside has", n_snapped));
  if (!answer.integral && answer.points.empty() && answer.line.empty())
    session.warn("the line meets no cell");
  if (!answer.report.memory_met)
    session.warn(
        fmt::format("the memory limit is too small for the tolerance: raise it (achieved error {})",
                    format_number(answer.report.achieved_error)));
}

void add_probe_rows(const ProbeAnswer& answer, Table& table) {
  const std::string suffix = std::string(" ") + name_of(answer.report.error_place);
  const bool is_full = answer.report.max_error == 0 && answer.report.achieved_error == 0;
  table.add({"max error",
             is_full ? std::string("0: full resolution") : format_number(answer.report.max_error)});
  if (answer.report.max_error > 0 || answer.report.achieved_error > 0)
    table.add({"achieved error", format_number(answer.report.achieved_error) + suffix});
  for (std::size_t f = 0; f < answer.with.size(); ++f) {
    const ProbedField& more = answer.report.along[f];
    table.add(
        {"with", answer.report.max_error == 0
                     ? answer.with[f]
                     : fmt::format("{}, error {} {}", answer.with[f],
                                   format_number(more.achieved_error), name_of(more.error_place))});
  }
  if (answer.integral && !answer.integral->is_empty) {
    const IntegralReport& report = *answer.integral;
    table.add({"cells", fmt::format("{}, {} of them whole", format_count(report.n_cells),
                                    format_count(report.n_whole))});
    table.add({"rounding", fmt::format("at most {:.3g} of the volume, {:.3g} of the integral",
                                       report.volume_rounding, report.integral_rounding)});
    if (report.integral_estimate > 0)
      table.add({"integral off by", format_number(report.integral_estimate) +
                                        (answer.report.error_place == ErrorPlace::everywhere
                                             ? " at most"
                                             : " by errors at samples, an estimate")});
  }
  table.add({"cells of the cut", format_count(answer.report.n_cut_cells)});
  table.add({"probe", format_seconds(answer.report.seconds)});
}

void finish_probe(const ProbeAnswer& answer, const Table& head, double open_seconds,
                  const Session& session, Outcome& outcome) {
  outcome.json.update(probe_json(answer));
  outcome.json["cut_cells"] = answer.report.n_cut_cells;
  outcome.json["outside"] = answer.report.n_outside;
  outcome.json["near_boundary"] = answer.report.n_near_boundary;
  outcome.json["seconds"] = {{"total", answer.report.seconds}, {"open", open_seconds}};
  outcome.json["warnings"] = session.warnings();
  const std::string rows = probe_table(answer);
  outcome.text = head.to_string() + (rows.empty() ? "" : '\n' + rows);
}

std::string probe_table(const ProbeAnswer& answer) {
  if (answer.integral) {
    if (answer.integral->is_empty) return "";
    Table table({"", "value", "low", "high"});
    for (const auto& [name, number] : numbers_of(answer))
      table.add({name, fmt::format("{:.10g}", number.value), fmt::format("{:.10g}", number.low),
                 fmt::format("{:.10g}", number.high)});
    return table.to_string();
  }
  Table table(headings_of(answer));
  visit_rows(answer, format_number,
             [&](std::vector<std::string> row) { table.add(std::move(row)); });
  return table.to_string();
}

Json probe_json(const ProbeAnswer& answer) {
  Json json;
  json["with"] = with_json(answer);
  if (answer.integral) {
    const IntegralReport& report = *answer.integral;
    json["volume"] = report.is_empty ? Json(nullptr) : bounded_json(report.volume);
    json["volume_rounding"] = report.volume_rounding;
    json.update(integral_json(report, report.is_empty, report.probe.error_place));
    json["cells"] = report.n_cells;
    json["whole_cells"] = report.n_whole;
    return json;
  }
  if (!answer.points.empty()) {
    Json& points = json["points"] = Json::array();
    for (const ProbedPoint& point : answer.points) points.push_back(point_json(point, answer));
    return json;
  }
  Json& line = json["line"] = Json::array();
  for (const ProbedLinePoint& point : answer.line) {
    Json one = point_json(point.at, answer);
    one["distance"] = point.distance;
    one["part"] = point.at.is_inside ? Json(point.part) : Json(nullptr);
    line.push_back(std::move(one));
  }
  return json;
}

std::string probe_csv(const ProbeAnswer& answer) {
  std::string text;
  if (answer.integral) {
    append_row(text, {"quantity", "value", "low", "high"});
    if (answer.integral->is_empty) return text;
    for (const auto& [name, number] : numbers_of(answer))
      append_row(text, {name, exact_number(number.value), exact_number(number.low),
                        exact_number(number.high)});
    return text;
  }
  append_row(text, headings_of(answer));
  visit_rows(answer, exact_number,
             [&](const std::vector<std::string>& row) { append_row(text, row); });
  return text;
}

}  // namespace lode::cli
