#include "lode/io/surface_output.h"

namespace lode::io {

Result<SurfaceOutput> SurfaceOutput::create(const std::string& path, std::uint64_t n_bytes,
                                            Progress& progress, Threads threads) {
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  return SurfaceOutput(std::move(file), n_bytes, progress, threads);
}

Result<void> SurfaceOutput::write(std::span<const std::byte> bytes) {
  constexpr std::size_t kPieceBytes = std::size_t{4} << 20;  // written in milliseconds
  while (!bytes.empty()) {
    if (progress_.is_cancelled()) return cancelled_error();
    const std::span<const std::byte> piece = bytes.first(std::min(bytes.size(), kPieceBytes));
    LODE_CHECK(file_.write(piece));
    bytes = bytes.subspan(piece.size());
    const auto done = static_cast<double>(file_.size());
    if (n_bytes_ > 0)
      progress_.report("writing", std::min(1.0, done / static_cast<double>(n_bytes_)), n_bytes_);
  }
  return {};
}

}  // namespace lode::io
