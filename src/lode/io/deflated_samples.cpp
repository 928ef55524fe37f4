#include "lode/io/deflated_samples.h"

#include "lode/io/inflate.h"
#include "lode/io/spooled_store.h"

namespace lode::io {

Result<std::unique_ptr<SampleStore>> load_inflated(const DeflatedSamples& samples,
                                                   const SampleStorage& storage) {
  const InputFilePtr& file = samples.file;
  LODE_CHECK(check_inflated_size(file->path(), samples.n_bytes, file->size_from(samples.offset)));
  auto stream = make_exact_inflate_stream(make_file_stream(file, samples.offset), file->path(),
                                          samples.n_skipped, samples.n_bytes);
  if (storage.holds(samples.n_bytes)) {
    LODE_TRY(std::vector<std::byte> bytes, read_promised(*stream, samples.n_bytes));
    return make_memory_store(std::move(bytes));
  }
  return make_spooled_store({.path = file->path(),
                             .stream = std::move(stream),
                             .n_bytes = samples.n_bytes,
                             .tally = file->tally()},
                            storage);
}

}  // namespace lode::io
