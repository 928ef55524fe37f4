#include "render_tetra_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "render_tetra.h"

namespace lode::cli {
namespace {

/// `n_updates`: nodes applied and undone for it.
Json frame_json(const TetraPicture& made, std::uint64_t n_updates, const TetraPicturePlan& plan) {
  Json frame;
  frame["updates"] = n_updates;
  frame["seconds"] = made.mesh.seconds;
  frame["render_seconds"] = made.picture.seconds;
  frame["cells"] = made.mesh.n_cells;
  frame["achieved_error"] = made.mesh.achieved_error;
  if (made.mesh.achieved_world_error)
    frame["achieved_space_error"] = *made.mesh.achieved_world_error;
  if (made.mesh.achieved_px) frame["achieved_px"] = *made.mesh.achieved_px;
  if (!plan.shown.isovalues.empty()) frame["triangles"] = made.picture.n_triangles;
  if (!plan.shown.sections.empty()) frame["section_triangles"] = made.picture.n_section_triangles;
  if (plan.shown.has_wireframe || plan.shown.has_points) frame["lines"] = made.picture.n_lines;
  if (plan.wanted.deadline_s) frame["is_settled"] = made.mesh.is_settled;
  frame["camera"] = camera_json(made.picture.camera);
  return frame;
}

/// What frames warn of, each message once, in the order in which they first came.
class FrameWarnings {
 public:
  void add(const std::vector<std::string>& messages, const std::string& frame) {
    for (const std::string& message : messages) {
      const auto found = std::ranges::find(said_, message, &Said::message);
      if (found == said_.end())
        said_.push_back({message, frame, 1});
      else
        ++found->n_frames;
    }
  }
  void say(std::size_t n_frames, Session& session) const {
    for (const Said& said : said_)
      session.warn(fmt::format("{} of {} frames, first {}: {}", said.n_frames, n_frames,
                               said.first_frame, said.message));
  }

 private:
  struct Said {
    std::string message;
    std::string first_frame;
    std::size_t n_frames;
  };
  std::vector<Said> said_;
};

/// Of all frames but the first.
double mean_of(const Json& frames, const char* key) {
  double sum = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) sum += frames[i][key].get<double>();
  return sum / static_cast<double>(frames.size() - 1);
}

double largest_of(const Json& frames, const char* key) {
  double largest = 0;
  for (const Json& frame : frames) largest = std::max(largest, frame[key].get<double>());
  return largest;
}

}  // namespace

Result<Json> draw_tetra_path(const TetraPathJob& job, Session& session, OutputSet& outputs) {
  TetraSession questions(job.input.dataset);
  FrameWarnings warnings;
  Json frames = Json::array();
  for (const Camera& camera : job.cameras) {
    const std::uint64_t n_before = questions.n_updates();
    LODE_TRY(const TetraPicture made,
             draw_picture(job.picture, job.input, job.plan, camera, questions, session));
    if (session.progress().is_cancelled()) return cancelled_error();
    const std::string name = fmt::format("frame-{:04}.png", frames.size());
    const std::string path = job.folder.path_of(name);
    LODE_CHECK(write_png(made.image, path));
    outputs.add(path);
    warnings.add(made.warnings, name);
    frames.push_back(frame_json(made, questions.n_updates() - n_before, job.plan));
    session.progress().report(
        "frames", static_cast<double>(frames.size()) / static_cast<double>(job.cameras.size()));
  }
  warnings.say(frames.size(), session);
  Json report;
  report["path"] = job.picture.path.path;
  report["view"] = job.picture.has_own_view() ? "each frame's" : "one for all frames";
  report["frames"] = std::move(frames);
  return report;
}

void add_tetra_path(const TetraPictureJob& job, const Json& path, Table& table) {
  const Json& frames = path["frames"];
  table.add({"frames", fmt::format("{} in {}", frames.size(), job.path.frames)});
  const auto in_words = [&](const char* key, const auto& format) {
    std::string words = format(frames[0][key].template get<double>());
    if (frames.size() > 1)
      words += fmt::format(", then {} a frame in the mean", format(mean_of(frames, key)));
    return words;
  };
  table.add({"updates of frames",
             in_words("updates", [](double n) {
               return format_count(static_cast<std::uint64_t>(std::llround(n)));
             }) + (job.has_own_view() ? "" : ": all have one view, and so one mesh")});
  table.add({"extract frames", in_words("seconds", format_seconds)});
  table.add({"render frames", in_words("render_seconds", format_seconds)});
  table.add({"cells of frames", fmt::format("up to {}", format_count(static_cast<std::uint64_t>(
                                                            largest_of(frames, "cells"))))});
  table.add({"error of frames", "up to " + format_number(largest_of(frames, "achieved_error"))});
  if (frames[0].contains("achieved_px"))
    table.add({"pixels of frames", fmt::format("up to {}, by an estimate",
                                               format_number(largest_of(frames, "achieved_px")))});
  const auto n_ended = std::ranges::count_if(
      frames, [](const Json& frame) { return !frame.value("is_settled", true); });
  if (n_ended > 0)
    table.add({"deadline", fmt::format("reached in {} frames: as accurate as it allows", n_ended)});
}

}  // namespace lode::cli
