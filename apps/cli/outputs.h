#pragma once

#include <string>
#include <vector>

#include "command.h"

namespace lode::cli {

/// Refuses extensions that are no surface format, with a hint where one is nearly right.
[[nodiscard]] Result<void> check_surface_extension(const std::string& path);

/// Refuses formats that cannot hold what extraction will give: contour lines of 2D data.
[[nodiscard]] Result<void> check_holds(const std::string& path, const VolumeInfo& volume);

/// Fails unless `path` ends in `extension`, which starts with a dot (any case).
[[nodiscard]] Result<void> check_extension(const std::string& path, const std::string& extension);

/// The files of isovalues: one for all where its format has an attribute to tell them apart, or
/// there is one of them; else one each, in their order: bone.stl and 1200 give bone-1200.stl.
[[nodiscard]] std::vector<std::string> paths_for_isovalues(const std::string& path,
                                                           const std::vector<double>& isovalues);

/// Files written by a command that makes several: unless keep() is called, those written so far
/// are taken away again, so that a failed command leaves no part of its result. Where one of them
/// replaced an older file it stays: it is whole, and the older one is gone.
class OutputSet {
 public:
  /// `planned`: the paths to be written.
  explicit OutputSet(const std::vector<std::string>& planned);
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;
  ~OutputSet();

  void add(std::string path) { paths_.push_back(std::move(path)); }
  [[nodiscard]] const std::vector<std::string>& paths() const { return paths_; }
  void keep() { is_kept_ = true; }

 private:
  std::vector<std::string> paths_;
  std::vector<std::string> replaced_;  ///< Those that were there before.
  bool is_kept_ = false;
};

}  // namespace lode::cli
