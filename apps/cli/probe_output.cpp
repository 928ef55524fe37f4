#include "probe_output.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace lode::cli {
namespace {

const char* status_of(const ProbedPoint& point) {
  if (point.is_near_boundary) return "near boundary";
  if (!point.is_inside) return "outside";
  return point.is_exact ? "exact" : "bounded";
}

/// The five numbers of an integral, by their names.
std::array<std::pair<const char*, BoundedNumber>, 5> numbers_of(const IntegralReport& report) {
  return {{{"volume", report.volume},
           {"integral", report.integral},
           {"mean", report.mean},
           {"minimum", report.minimum},
           {"maximum", report.maximum}}};
}

std::vector<std::string> headings_of(const ProbeAnswer& answer) {
  std::vector<std::string> headings;
  if (!answer.line.empty()) headings = {"part", "distance"};
  headings.insert(headings.end(), {"x", "y", "z", "status", "value", "low", "high", "error"});
  if (answer.has_regions) headings.emplace_back("region");
  return headings;
}

/// `format(number)`: as text.
template <typename Format>
std::vector<std::string> row_of(const ProbedPoint& point, bool has_region, const Format& format) {
  std::vector<std::string> row;
  for (const double x : point.point.v) row.push_back(format(x));
  row.emplace_back(status_of(point));
  const bool has_bounds = point.is_inside || point.is_near_boundary;
  row.push_back(point.is_inside ? format(point.value.value) : "");
  for (const double x : {point.value.low, point.value.high})
    row.push_back(has_bounds ? format(x) : "");
  row.push_back(point.is_inside ? format(point.error) : "");
  if (has_region) row.push_back(point.is_inside ? fmt::format("{}", point.region) : "");
  return row;
}

/// Calls add(row) for each.
template <typename Format, typename Add>
void visit_rows(const ProbeAnswer& answer, const Format& format, const Add& add) {
  for (const ProbedPoint& point : answer.points) add(row_of(point, answer.has_regions, format));
  for (const ProbedLinePoint& point : answer.line) {
    std::vector<std::string> row{point.at.is_inside ? fmt::format("{}", point.part) : "",
                                 format(point.distance)};
    for (std::string& text : row_of(point.at, answer.has_regions, format))
      row.push_back(std::move(text));
    add(std::move(row));
  }
}

Json bounded_json(const BoundedNumber& number) {
  return {{"value", number.value}, {"low", number.low}, {"high", number.high}};
}

Json point_json(const ProbedPoint& point, bool has_region) {
  Json json;
  json["point"] = point.point.v;
  json["status"] = status_of(point);
  if (point.is_near_boundary) {
    json["low"] = point.value.low;
    json["high"] = point.value.high;
  }
  if (!point.is_inside) return json;
  json.update(bounded_json(point.value));
  json["error"] = point.error;
  if (has_region) json["region"] = point.region;
  return json;
}

void append_row(std::string& text, const std::vector<std::string>& row) {
  for (std::size_t i = 0; i < row.size(); ++i) text += (i == 0 ? "" : ",") + row[i];
  text += '\n';
}

std::string exact_number(double x) { return fmt::format("{}", x); }

}  // namespace

std::string probe_table(const ProbeAnswer& answer) {
  if (answer.integral) {
    if (answer.integral->is_empty) return "";
    Table table({"", "value", "low", "high"});
    for (const auto& [name, number] : numbers_of(*answer.integral))
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
  if (answer.integral) {
    const IntegralReport& report = *answer.integral;
    for (const auto& [name, number] : numbers_of(report))
      json[name] = report.is_empty ? Json(nullptr) : bounded_json(number);
    json["volume_rounding"] = report.volume_rounding;
    json["integral_rounding"] = report.integral_rounding;
    const bool is_estimate = report.probe.error_place == ErrorPlace::at_samples;
    json[is_estimate ? "integral_error_estimate" : "integral_error"] = report.integral_estimate;
    json["cells"] = report.n_cells;
    json["whole_cells"] = report.n_whole;
    return json;
  }
  if (!answer.points.empty()) {
    Json& points = json["points"] = Json::array();
    for (const ProbedPoint& point : answer.points)
      points.push_back(point_json(point, answer.has_regions));
    return json;
  }
  Json& line = json["line"] = Json::array();
  for (const ProbedLinePoint& point : answer.line) {
    Json one = point_json(point.at, answer.has_regions);
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
    for (const auto& [name, number] : numbers_of(*answer.integral))
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
