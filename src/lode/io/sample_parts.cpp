#include "lode/io/sample_parts.h"

#include <algorithm>
#include <utility>

namespace lode::io {
namespace {

class PartsStore final : public SampleStore {
 public:
  explicit PartsStore(SampleParts<SampleStore> parts) : parts_(std::move(parts)) {}

  Result<void> read(std::uint64_t offset, std::span<std::byte> out) override {
    while (!out.empty()) {
      LODE_CHECK(go_to(static_cast<std::size_t>(offset / parts_.n_bytes_each)));
      const std::uint64_t skipped = offset % parts_.n_bytes_each;
      const auto n = static_cast<std::size_t>(
          std::min<std::uint64_t>(out.size(), parts_.n_bytes_each - skipped));
      LODE_CHECK(store_->read(skipped, out.first(n)));
      out = out.subspan(n);
      offset += n;
    }
    return {};
  }

 private:
  Result<void> go_to(std::size_t part) {
    LODE_EXPECTS(part < parts_.n_parts);
    if (store_ && part == part_) return {};
    store_.reset();
    LODE_TRY(store_, parts_.open(part));
    part_ = part;
    return {};
  }

  SampleParts<SampleStore> parts_;
  std::unique_ptr<SampleStore> store_;
  std::size_t part_ = 0;  ///< Of store_.
};

class PartsStream final : public ByteStream {
 public:
  explicit PartsStream(SampleParts<ByteStream> parts) : parts_(std::move(parts)) {}

  Result<void> read(std::span<std::byte> out) override {
    LODE_EXPECTS(out.size() <= n_left());
    while (!out.empty()) {
      if (!stream_) {
        LODE_TRY(stream_, parts_.open(part_));
      }
      const auto n = static_cast<std::size_t>(
          std::min<std::uint64_t>(out.size(), parts_.n_bytes_each - n_done_));
      LODE_CHECK(stream_->read(out.first(n)));
      out = out.subspan(n);
      n_done_ += n;
      if (n_done_ == parts_.n_bytes_each) go_on();
    }
    return {};
  }

  std::uint64_t n_left() const override {
    return (parts_.n_parts - part_) * parts_.n_bytes_each - n_done_;
  }

 private:
  void go_on() {
    stream_.reset();
    ++part_;
    n_done_ = 0;
  }

  SampleParts<ByteStream> parts_;
  std::unique_ptr<ByteStream> stream_;  ///< Of part_; none before its first byte.
  std::size_t part_ = 0;
  std::uint64_t n_done_ = 0;  ///< Of part_.
};

}  // namespace

std::unique_ptr<SampleStore> make_parts_store(SampleParts<SampleStore> parts) {
  return std::make_unique<PartsStore>(std::move(parts));
}

std::unique_ptr<ByteStream> make_parts_stream(SampleParts<ByteStream> parts) {
  return std::make_unique<PartsStream>(std::move(parts));
}

}  // namespace lode::io
