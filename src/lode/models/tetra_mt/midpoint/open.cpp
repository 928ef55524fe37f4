#include <algorithm>
#include <memory>
#include <utility>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/midpoint/field_blocks.h"
#include "lode/models/tetra_mt/midpoint/file_layout.h"
#include "lode/models/tetra_mt/midpoint/forest_blocks.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt::midpoint {
namespace {

auto keys_of(Kind kind) {
  return [kind](std::uint32_t part) { return key_of(kind, part); };
}

class ForestBaseReader {
 public:
  ForestBaseReader(const store::Reader& reader, const ForestCounts& counts, ForestHead& head)
      : reader_(reader), counts_(counts), head_(head) {}

  Result<void> run() {
    LODE_CHECK(check_base_memory(reader_,
                                 counts_.n_tetrahedra * kBaseTetrahedronBytes +
                                     counts_.n_roots * (sizeof(Code) + 2 * sizeof(std::uint32_t))));
    LODE_CHECK(read_table());
    LODE_CHECK(read_parts(reader_, counts_.n_roots, keys_of(Kind::roots),
                          [&](StreamReader& in, std::size_t n) { return read_roots(in, n); }));
    LODE_CHECK(read_tetrahedra());
    const auto n_inside = std::ranges::count_if(head_.base, [&](const Tetrahedron& t) {
      return std::ranges::find(t, head_.outside()) == t.end();
    });
    if (static_cast<std::uint64_t>(n_inside) == head_.n_base_cells) return {};
    return fail("{}: expected {} cells of the base, got {}", reader_.path(), head_.n_base_cells,
                n_inside);
  }

 private:
  /// As no page is without a block, a table of more than the file has is refused before it is read.
  Result<void> read_table() {
    std::vector<PageCounts> pages;
    for (std::uint32_t page = 0; page < counts_.n_pages; ++page)
      if (!reader_.find(key_of(Kind::page, page)))
        return fail("{}: expected {}, found none", reader_.path(),
                    store::describe(key_of(Kind::page, page)));
    std::uint64_t n_leaves = head_.n_base_leaves;
    std::uint64_t n_nodes = 0;
    for (std::uint32_t first = 0; first < counts_.n_pages; first += kTablePart) {
      const store::BlockKey key = key_of(Kind::table, first / kTablePart);
      LODE_TRY(const auto bytes, read_block(reader_, key));
      LODE_CHECK(decode_table(bytes, reader_.path() + ": " + store::describe(key),
                              std::min(kTablePart, counts_.n_pages - first), pages));
    }
    for (const PageCounts& page : pages) {
      n_leaves += page.n_leaves;
      for (const PageCounts::Group& group : page.groups) n_nodes += group.n;
    }
    if (n_leaves != head_.n_vertices || head_.n_vertices + n_nodes >= kNone)
      return fail(
          "{}: expected {} vertices in pages and the base, and labels below {}, got {} and "
          "{} nodes",
          reader_.path(), head_.n_vertices, kNone, n_leaves, n_nodes);
    // Each split makes one vertex two: a tree of other numbers names vertices more than once.
    if (counts_.n_roots + n_nodes != head_.n_vertices)
      return fail("{}: expected {} nodes, which make {} vertices of {}, got {}", reader_.path(),
                  std::int64_t{head_.n_vertices} - std::int64_t{counts_.n_roots}, head_.n_vertices,
                  counts_.n_roots, n_nodes);
    head_.pages = PageTable(head_.n_base_leaves, pages);
    head_.n_inner = head_.pages.n_nodes();
    return {};
  }

  /// Leaves first, which are numbered from 0 on.
  Result<void> read_roots(StreamReader& in, std::size_t n) {
    LODE_TRY(const auto labels, read_differences_of(in, n));
    for (const std::uint32_t label : labels) {
      const std::size_t place = head_.roots.size();
      const bool is_right = place < head_.n_base_leaves
                                ? label == place
                                : label >= head_.n_vertices && label < head_.n_labels() &&
                                      (place == 0 || label > head_.roots.back());
      if (!is_right)
        return fail("{}: expected {} leaves and then nodes that ascend up to {}, got {}", in.what(),
                    head_.n_base_leaves, head_.n_labels(), label);
      head_.roots.push_back(label);
    }
    const std::size_t first = head_.root_codes.size();
    head_.root_codes.resize(first + n);
    for (std::size_t axis = 0; axis < 4; ++axis) {
      LODE_TRY(const auto column, read_codes_of(in, n));
      for (std::size_t i = 0; i < n; ++i) head_.root_codes[first + i][axis] = column[i];
    }
    LODE_TRY(const auto facts, read_facts_of(in, n, head_.fields[0].codes));
    head_.root_facts.insert(head_.root_facts.end(), facts.begin(), facts.end());
    return read_offsets(in, first, n);
  }
  Result<void> read_offsets(StreamReader& in, std::size_t first, std::size_t n) {
    LODE_TRY(const auto is_off, in.read(n));
    const auto n_off = static_cast<std::size_t>(
        std::ranges::count_if(is_off, [](std::uint8_t is) { return is != 0; }));
    LODE_TRY(const auto numbers, read_numbers(in, n_off, 4, false));
    std::size_t next = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (is_off[i] == 0) continue;
      if (is_off[i] > 1 || first + i >= head_.n_base_leaves)
        return fail("{}: expected offsets of {} leaves, got {} of root {}", in.what(),
                    head_.n_base_leaves, is_off[i], first + i);
      LeafOffset offset;
      for (std::size_t axis = 0; axis < 4; ++axis) {
        offset.axes[axis] = numbers[next++];
        LODE_CHECK(check_offset(offset.axes[axis],
                                axis < 3 ? head_.scales.axes()[axis] : head_.fields[0].scale,
                                in.what()));
      }
      head_.base_exact.add(static_cast<std::uint32_t>(first + i), offset);
    }
    return {};
  }

  Result<void> read_tetrahedra() {
    const auto key = key_of(Kind::base_tetrahedra, 0);
    LODE_TRY(const auto bytes, read_block(reader_, key));
    LODE_TRY(auto base,
             decode_base(bytes, counts_.n_tetrahedra, base_limits_of(head_, counts_.n_roots),
                         reader_.path() + ": " + store::describe(key)));
    for (Tetrahedron& t : base.corners)
      for (std::uint32_t& v : t) v = v == counts_.n_roots ? head_.outside() : head_.roots[v];
    head_.base = std::move(base.corners);
    head_.base_regions = std::move(base.regions);
    return {};
  }

  const store::Reader& reader_;
  ForestCounts counts_;
  ForestHead& head_;
};

/// That what fields have is there, and what tells leaves apart, so that what is asked for later is
/// in the file.
Result<void> check_fields(const store::Reader& reader, const ForestHead& head) {
  const std::uint32_t n_parts =
      static_cast<std::uint32_t>((head.roots.size() + kBasePart - 1) / kBasePart);
  const auto check = [&](const store::BlockKey& key) -> Result<void> {
    if (reader.find(key)) return {};
    return fail("{}: expected {}, found none", reader.path(), store::describe(key));
  };
  for (std::uint32_t first = 0; first < head.n_coincident_leaves; first += kBasePart)
    LODE_CHECK(check(key_of(Kind::coincident_leaves, first / kBasePart)));
  for (std::size_t f = 0; f < head.fields.size(); ++f) {
    for (std::uint32_t page = 0; head.fields[f].base_world_error && page < head.pages.n_pages();
         ++page)
      LODE_CHECK(check(key_of(Kind::world_errors, page, f)));
    if (f == 0) continue;
    for (std::uint32_t part = 0; part < n_parts; ++part)
      LODE_CHECK(check(key_of(Kind::field_roots, part, f)));
    for (std::uint32_t page = 0; page < head.pages.n_pages(); ++page)
      LODE_CHECK(check(key_of(Kind::field_page, page, f)));
  }
  return {};
}

Result<std::vector<std::uint32_t>> read_coincident(const store::Reader& reader, std::uint32_t n,
                                                   std::uint32_t n_vertices) {
  std::vector<std::uint32_t> leaves;
  std::vector<bool> is_there(n_vertices, false);
  LODE_CHECK(read_parts(reader, n, keys_of(Kind::coincident_leaves),
                        [&](StreamReader& in, std::size_t n_here) -> Result<void> {
                          LODE_TRY(const auto labels, read_differences_of(in, n_here));
                          for (const std::uint32_t leaf : labels) {
                            if (leaf >= n_vertices || is_there[leaf])
                              return fail("{}: expected leaves below {}, each once, got {}",
                                          in.what(), n_vertices, leaf);
                            is_there[leaf] = true;
                            leaves.push_back(leaf);
                          }
                          return {};
                        }));
  return leaves;
}

}  // namespace

bool is_model_of(const std::string& path) {
  const auto name = store::Reader::model_of(path);
  return name && *name == kModelName;
}

Result<OpenedForest> open(const std::string& path) {
  LODE_TRY(auto opened, store::Reader::open(path));
  const auto reader = std::make_shared<const store::Reader>(std::move(opened));
  if (reader->model() != kModelName)
    return fail("{}: expected the model {}, got {}", path, kModelName, reader->model());
  ForestCounts counts;
  LODE_TRY(ForestHead head, decode_head(reader->metadata(), path, counts));
  LODE_CHECK(ForestBaseReader(*reader, counts, head).run());
  LODE_CHECK(check_fields(*reader, head));
  Forest::Load load;
  load.nodes = [reader](const ForestHead& of, std::uint32_t page) -> Result<ForestContent> {
    const store::BlockKey key = key_of(Kind::page, page);
    LODE_TRY(const auto bytes, read_block(*reader, key));
    return decode_page(bytes, reader->path() + ": " + store::describe(key), of, page);
  };
  load.roots = [reader](const ForestHead& of, std::size_t field) -> Result<FieldRoots> {
    FieldRoots roots;
    LODE_CHECK(read_parts(
        *reader, of.roots.size(),
        [&](std::uint32_t part) { return key_of(Kind::field_roots, part, field); },
        [&](StreamReader& in, std::size_t n) {
          return read_field_roots(in, n, of, of.fields[field], roots);
        }));
    return roots;
  };
  load.field = [reader](const ForestHead& of, std::size_t field, std::uint32_t page,
                        const ForestPage& nodes) -> Result<FieldPage> {
    const store::BlockKey key = key_of(Kind::field_page, page, field);
    LODE_TRY(const auto bytes, read_block(*reader, key));
    return decode_field_page(bytes, reader->path() + ": " + store::describe(key), of,
                             of.fields[field], page, nodes);
  };
  load.world_errors = [reader](const ForestHead& of, std::size_t field,
                               std::uint32_t page) -> Result<WorldPage> {
    const store::BlockKey key = key_of(Kind::world_errors, page, field);
    LODE_TRY(const auto bytes, read_block(*reader, key));
    StreamReader in(bytes, reader->path() + ": " + store::describe(key));
    LODE_TRY(auto codes, in.read(of.pages.n_nodes_of(page)));
    LODE_CHECK(in.expect_end());
    return codes;
  };
  auto coincident_leaves = [reader, n = head.n_coincident_leaves, n_vertices = head.n_vertices] {
    return read_coincident(*reader, n, n_vertices);
  };
  return OpenedForest{Forest(std::move(head), std::move(load)), std::move(coincident_leaves),
                      [reader] {
                        return FileReads{reader->reads().n_bytes, reader->file_size()};
                      }};
}

}  // namespace lode::tetra_mt::midpoint
