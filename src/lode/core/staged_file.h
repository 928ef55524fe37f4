#pragma once

#include <string>
#include <utility>

#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode {

/// An output that a library writes by name, whole or not at all: in a folder of its own beside
/// `path`, which is gone when this is. Only a process that is killed leaves the folder behind.
class StagedFile {
 public:
  /// Makes the folder. Fails, naming `path`, where that cannot be.
  [[nodiscard]] static Result<StagedFile> create(std::string path);

  StagedFile(StagedFile&& other) noexcept
      : path_(std::move(other.path_)), folder_(std::exchange(other.folder_, {})) {}
  StagedFile& operator=(StagedFile&&) = delete;
  ~StagedFile();

  /// The name to write: what `path` is called, in the folder.
  [[nodiscard]] std::string name() const;
  /// Moves the file, written and closed, to `path` when it outlasts a loss of power. Fails when
  /// `progress` is cancelled before.
  [[nodiscard]] Result<void> commit(const Progress& progress);

 private:
  StagedFile(std::string path, std::string folder)
      : path_(std::move(path)), folder_(std::move(folder)) {}

  std::string path_;
  std::string folder_;  ///< Empty: moved away.
};

/// A folder of many files that appears whole or not at all: filled under another name beside
/// `path`, which is gone when this is. Only a process that is killed leaves it behind.
class StagedFolder {
 public:
  /// Fails, naming `path`, where that is a file, a link or a folder with something in it, has no
  /// name of its own ("", ".", ".."), or nothing can be made beside it.
  [[nodiscard]] static Result<StagedFolder> create(std::string path);

  StagedFolder(StagedFolder&& other) noexcept
      : path_(std::move(other.path_)), folder_(std::exchange(other.folder_, {})) {}
  StagedFolder& operator=(StagedFolder&&) = delete;
  ~StagedFolder();

  /// Where to put files until commit().
  [[nodiscard]] const std::string& folder() const { return folder_; }
  /// Renames it to `path` when all that is in it outlasts a loss of power. Fails when `progress` is
  /// cancelled before.
  [[nodiscard]] Result<void> commit(const Progress& progress);

 private:
  StagedFolder(std::string path, std::string folder)
      : path_(std::move(path)), folder_(std::move(folder)) {}

  std::string path_;
  std::string folder_;  ///< Empty: moved away.
};

}  // namespace lode
