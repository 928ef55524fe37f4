#include "salvage.h"

#include <fmt/format.h>

namespace lode::cli {
namespace {

Json box_json(const std::optional<Box3d>& box) {
  if (!box) return {};
  Json json;
  json["lower"] = box->lower.v;
  json["upper"] = box->upper.v;
  return json;
}

std::string box_text(const Box3d& box) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    text += fmt::format("{}{} to {}", i == 0 ? "" : ", ", format_number(box.lower[i]),
                        format_number(box.upper[i]));
  return text;
}

Json block_json(const LostBlock& block) {
  Json json;
  json["kind"] = block.kind;
  json["level"] = block.level;
  json["position"] = block.position.v;
  json["samples"] = block.n_samples;
  json["max_error"] = block.max_error;
  json["box"] = box_json(block.box);
  json["reason"] = block.reason;
  return json;
}

Json level_json(const LostLevel& level) {
  Json json;
  json["level"] = level.level;
  json["blocks"] = level.n_blocks;
  json["samples"] = level.n_samples;
  json["max_error"] = level.max_error;
  return json;
}

/// Nothing where the lost region is as whole as it was.
std::string mask_text(const SalvageReport& report) {
  if (report.n_lost_holes == 0 || report.n_lost_holes == report.n_samples) return "";
  return fmt::format(
      "{} of the lost samples were holes, which is not known: {} are filled as holes, so cells may "
      "be missing or too many",
      format_count(report.n_lost_holes), format_count(report.n_filled_holes));
}

}  // namespace

void warn_of_damage(Session& session, const std::string& path, const SalvageReport& report) {
  if (report.blocks.empty()) return;
  const std::string blocks =
      fmt::format("{}: {} of {} blocks are lost", path, format_count(report.blocks.size()),
                  format_count(report.n_blocks));
  if (report.n_samples == 0) {
    session.warn(blocks + ", but no sample is lost: the answer is that of the whole file");
    return;
  }
  session.warn(
      fmt::format("{}: {} samples are lost and filled from coarser ones, each within {} of what it "
                  "was, in the box {}",
                  blocks, format_count(report.n_samples), format_number(report.max_error),
                  box_text(*report.box)));
  if (const std::string mask = mask_text(report); !mask.empty()) session.warn(mask);
}

void add_salvage(Json& json, const SalvageReport* report, double achieved) {
  if (report == nullptr) return;
  Json& salvage = json["salvage"];
  salvage["blocks"] = report->n_blocks;
  salvage["lost_blocks"] = report->blocks.size();
  salvage["lost_samples"] = report->n_samples;
  salvage["max_fill_error"] = report->max_error;
  salvage["achieved_error"] = achieved + report->max_error;
  salvage["lost_holes"] = report->n_lost_holes;
  salvage["filled_holes"] = report->n_filled_holes;
  salvage["box"] = box_json(report->box);
  salvage["levels"] = Json::array();
  for (const LostLevel& level : report->levels) salvage["levels"].push_back(level_json(level));
  salvage["lost"] = Json::array();
  for (const LostBlock& block : report->blocks) salvage["lost"].push_back(block_json(block));
}

void add_salvage(Table& table, const SalvageReport* report, double achieved) {
  if (report == nullptr) return;
  table.add({"lost blocks", fmt::format("{} of {}", format_count(report->blocks.size()),
                                        format_count(report->n_blocks))});
  for (const LostLevel& level : report->levels) {
    std::string text = format_count(level.n_blocks);
    if (level.n_samples > 0)
      text += fmt::format(", with {} samples, filled within {}", format_count(level.n_samples),
                          format_number(level.max_error));
    table.add({fmt::format("  of level {}", level.level), text});
  }
  if (!report->box) return;
  table.add({"box of the loss", box_text(*report->box)});
  table.add({"error there", fmt::format("{} of the field as it was",
                                        format_number(achieved + report->max_error))});
}

std::string salvage_comment(const SalvageReport* report) {
  if (report == nullptr || report->n_samples == 0) return "";
  return fmt::format(" of a salvaged field within {} of the original", report->max_error);
}

Error suggest_salvage(const Error& error, const std::string& path) {
  // What names the file though its blocks can be found is said of them, or of its end.
  if (!error.message.starts_with(path + ": ") || !can_salvage(path)) return error;
  return Error(error.message + "; --salvage extracts from what is whole");
}

}  // namespace lode::cli
