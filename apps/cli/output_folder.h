#pragma once

#include <string>

#include "lode/api/dataset.h"

namespace lode::cli {

/// A directory for the files of one command: made here or empty before. Unless keep() is called it
/// is taken away again, if it was made and the files in it are gone.
class OutputFolder {
 public:
  /// An empty path makes none. The directory above must be there.
  [[nodiscard]] static Result<OutputFolder> make(const std::string& path);
  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  /// Of a file in it.
  [[nodiscard]] std::string path_of(const std::string& name) const;
  void keep() { is_made_ = false; }

 private:
  OutputFolder(std::string path, bool is_made) : path_(std::move(path)), is_made_(is_made) {}

  std::string path_;
  bool is_made_ = false;  ///< And to be taken away.
};

}  // namespace lode::cli
