#include "lode/api/file_check.h"

#include <fmt/format.h>

#include <new>

#include "lode/core/out_of_memory.h"
#include "lode/store/reader.h"

namespace lode {

Result<VerifyReport> verify_every_byte(const std::string& path, Threads threads,
                                       Progress& progress) try {
  LODE_TRY(const auto reader, store::Reader::open(path));
  LODE_CHECK(reader.check_all(threads, progress));
  VerifyReport report;
  report.add("every byte of the file", reader.file_size(), 0,
             fmt::format("{} blocks", reader.blocks().size()));
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("check the file", path);
}

}  // namespace lode
