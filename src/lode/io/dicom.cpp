#include "lode/io/dicom.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace lode::io {
namespace {

/// By the mark behind the preamble.
bool is_dicom_file(const std::filesystem::path& path) {
  constexpr std::streamoff kPreamble = 128;
  constexpr std::string_view kMark = "DICM";
  std::ifstream file(path, std::ios::binary);
  std::array<char, kMark.size()> mark{};
  file.seekg(kPreamble);
  file.read(mark.data(), mark.size());
  return file && std::string_view(mark.data(), mark.size()) == kMark;
}

bool has_dicom_files(const std::filesystem::path& directory) {
  constexpr int kMostFiles = 16;
  std::error_code error;
  int n = 0;
  for (std::filesystem::directory_iterator it(directory, error), end; !error && it != end;
       it.increment(error)) {
    if (!it->is_regular_file(error)) continue;
    if (is_dicom_file(it->path())) return true;
    if (++n == kMostFiles) break;
  }
  return false;
}

}  // namespace

std::optional<Error> refuse_dicom(const std::string& path) {
  std::error_code error;
  const bool is_directory = std::filesystem::is_directory(path, error);
  if (is_directory ? !has_dicom_files(path) : !is_dicom_file(path)) return std::nullopt;
  return fail(
      "{}: expected a volume in one file, got DICOM, which is not read: dcm2niix makes .nii files "
      "of "
      "a folder of it, 3D Slicer .nrrd",
      path);
}

}  // namespace lode::io
