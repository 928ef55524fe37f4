#include "lode/io/deflated_samples.h"

#include "lode/io/inflate.h"
#include "lode/io/spooled_store.h"

namespace lode::io {

Result<std::unique_ptr<ByteStream>> inflated_stream(const DeflatedSamples& samples) {
  const InputFilePtr& file = samples.file;
  LODE_CHECK(check_inflated_size(file->path(), samples.n_bytes, file->size_from(samples.offset)));
  return make_exact_inflate_stream(make_file_stream(file, samples.offset), file->path(),
                                   samples.n_skipped, samples.n_bytes);
}

Result<std::unique_ptr<SampleStore>> load_inflated(const DeflatedSamples& samples,
                                                   const SampleStorage& storage) {
  LODE_TRY(std::unique_ptr<ByteStream> stream, inflated_stream(samples));
  if (storage.holds(samples.n_bytes)) {
    LODE_TRY(std::vector<std::byte> bytes, read_promised(*stream, samples.n_bytes));
    return make_memory_store(std::move(bytes));
  }
  return make_spooled_store({.path = samples.file->path(),
                             .stream = std::move(stream),
                             .n_bytes = samples.n_bytes,
                             .tally = samples.file->tally()},
                            storage);
}

}  // namespace lode::io
