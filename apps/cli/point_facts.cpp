#include "point_facts.h"

namespace lode::cli {
namespace {

/// Points are moved where it is by more than rounding, of places that may be far from the origin.
bool is_moved(const PointFacts& facts) {
  constexpr double kRounding = 0.01;
  return facts.largest_move > kRounding * facts.step;
}

std::string classes_text(const PointCounts& counts) {
  std::string text;
  for (std::size_t i = 0; i < counts.of_class.size(); ++i)
    if (counts.of_class[i] > 0)
      text +=
          fmt::format("{}{}: {}", text.empty() ? "" : ", ", i, format_count(counts.of_class[i]));
  return text;
}

std::string left_out_text(const PointFacts& facts) {
  std::string text;
  const auto add = [&](std::uint64_t n, const char* why) {
    if (n > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", format_count(n), why);
  };
  add(facts.counts.n_other_class, "of other classes");
  add(facts.counts.n_withheld, "withheld");
  add(facts.n_outside, "outside of the outline");
  add(facts.n_left_out, "in no triangle of the domain");
  return text;
}

const char* repeated_name(RepeatedHeights repeated) {
  if (repeated == RepeatedHeights::lowest) return "lowest";
  return repeated == RepeatedHeights::highest ? "highest" : "mean";
}

}  // namespace

void add_point_facts(const PointFacts& facts, Json& json, Table& table) {
  const PointCounts& counts = facts.counts;
  json["points_in_file"] = counts.n_in_file;
  json["positions"] = facts.n_nodes;
  json["left_out"] = {{"other_classes", counts.n_other_class},
                      {"withheld", counts.n_withheld},
                      {"outside_outline", facts.n_outside},
                      {"outside_domain", facts.n_left_out}};
  json["synthetic_points"] = counts.n_synthetic;
  json["repeated_positions"] = facts.n_repeated;
  json["largest_spread"] = facts.largest_spread;
  json["lattice_step"] = facts.step;
  json["largest_move"] = facts.largest_move;
  json["outline_edges"] = facts.n_outline;
  json["turned_points"] = facts.n_turned;
  if (facts.has_classes) {
    Json& classes = json["classes"] = Json::object();
    for (std::size_t i = 0; i < counts.of_class.size(); ++i)
      if (counts.of_class[i] > 0) classes[fmt::format("{}", i)] = counts.of_class[i];
  }
  table.add({"points", fmt::format("{} at {} positions", format_count(counts.n_in_file),
                                   format_count(facts.n_nodes))});
  if (facts.has_classes) table.add({"classes", classes_text(counts)});
  if (const std::string text = left_out_text(facts); !text.empty()) table.add({"left out", text});
  if (counts.n_synthetic > 0) table.add({"synthetic", format_count(counts.n_synthetic)});
  if (facts.n_turned > 0)
    table.add({"turned", fmt::format("{} points, whose longitudes are a turn more than in the file",
                                     format_count(facts.n_turned))});
  if (facts.n_repeated > 0)
    table.add({"repeated",
               fmt::format("{} points at positions of others, whose heights differ by up to {}",
                           format_count(facts.n_repeated), format_number(facts.largest_spread))});
  table.add({"lattice",
             fmt::format("steps of {}, points {}", format_number(facts.step),
                         is_moved(facts) ? "moved by up to " + format_number(facts.largest_move)
                                         : "on it, to rounding")});
  table.add({"outline", fmt::format("{} edges", format_count(facts.n_outline))});
}

void warn_of_points(const PointFacts& facts, const std::string& path, RepeatedHeights repeated,
                    Session& session) {
  if (!facts.crs_note.empty())
    session.warn(fmt::format("{}: the CRS was not read: {}; --crs says it", path, facts.crs_note));
  if (facts.n_turned > 0)
    session.warn(fmt::format(
        "{}: points lie on both sides of where longitudes jump; to those of {} points a "
        "turn was added, so that all lie side by side",
        path, format_count(facts.n_turned)));
  if (facts.largest_spread > 0)
    session.warn(
        fmt::format("{}: heights at one position differ by up to {}; the {} stands for them "
                    "(--duplicates)",
                    path, format_number(facts.largest_spread), repeated_name(repeated)));
  if (is_moved(facts))
    session.warn(
        fmt::format("{}: points are moved by up to {}, to a lattice of steps of {}: errors "
                    "hold there",
                    path, format_number(facts.largest_move), format_number(facts.step)));
}

}  // namespace lode::cli
