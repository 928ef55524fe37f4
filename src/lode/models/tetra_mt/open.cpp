#include <algorithm>
#include <memory>
#include <utility>

#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/elements.h"
#include "lode/store/reader.h"

namespace lode::tetra_mt {
namespace {

Result<std::vector<std::byte>> read_block(const store::Reader& reader, const store::BlockKey& key) {
  const auto at = reader.find(key);
  if (!at) return fail("{}: expected {}, found none", reader.path(), store::describe(key));
  return reader.read_block(*at);
}

Result<std::vector<std::uint32_t>> take_numbers(StreamReader& in, std::size_t n) {
  LODE_TRY(auto numbers, in.read_planes<std::uint32_t>(n));
  std::uint32_t last = 0;
  for (std::uint32_t& number : numbers) last = number = last + store::unzigzag(number);
  return numbers;
}

class BaseReader {
 public:
  BaseReader(const store::Reader& reader, const BaseCounts& counts, HierarchyHead& head)
      : reader_(reader), counts_(counts), head_(head) {}

  Result<void> run() {
    LODE_CHECK(check_memory());
    LODE_CHECK(read_parts(Kind::base_vertices, head_.shape.n_base_vertices,
                          [&](StreamReader& in, std::size_t n) { return read_vertices(in, n); }));
    LODE_CHECK(read_parts(Kind::base_tetrahedra, counts_.n_tetrahedra,
                          [&](StreamReader& in, std::size_t n) { return read_tetrahedra(in, n); }));
    LODE_CHECK(read_parts(Kind::roots, counts_.n_roots,
                          [&](StreamReader& in, std::size_t n) { return read_roots(in, n); }));
    const auto n_inside = std::ranges::count_if(head_.base, [&](const Tetrahedron& t) {
      return std::ranges::find(t, head_.outside()) == t.end();
    });
    if (static_cast<std::uint64_t>(n_inside) != head_.n_base_cells)
      return fail("{}: expected {} cells of the base, got {}", reader_.path(), head_.n_base_cells,
                  n_inside);
    return {};
  }

 private:
  /// Columns of zeros take nothing: what is asked for is bounded by the file beforehand.
  Result<void> check_memory() const {
    constexpr std::uint64_t kPerByte = 64;
    constexpr std::uint64_t kAlways = std::uint64_t{64} << 20;
    const std::uint64_t n_bytes =
        head_.shape.n_base_vertices * (sizeof(Vec3d) + sizeof(double) * head_.shape.n_fields) +
        counts_.n_tetrahedra * (sizeof(Tetrahedron) + sizeof(std::uint32_t)) +
        counts_.n_roots * sizeof(std::uint32_t);
    if (n_bytes <= kPerByte * reader_.file_size() + kAlways) return {};
    return fail("{}: expected a base that {} bytes may hold, got one of {} bytes", reader_.path(),
                reader_.file_size(), n_bytes);
  }
  template <typename Read>
  Result<void> read_parts(Kind kind, std::uint64_t n, const Read& read) {
    for (std::uint64_t first = 0; first < n; first += kBasePart) {
      const auto key = key_of(kind, static_cast<std::uint32_t>(first / kBasePart));
      LODE_TRY(const auto bytes, read_block(reader_, key));
      StreamReader in(bytes, reader_.path() + ": " + store::describe(key));
      LODE_CHECK(read(in, static_cast<std::size_t>(std::min<std::uint64_t>(kBasePart, n - first))));
      LODE_CHECK(in.expect_end());
    }
    return {};
  }
  Result<void> read_vertices(StreamReader& in, std::size_t n) {
    LODE_TRY(const auto coordinates, read_numbers(in, n, 3, head_.shape.has_narrow_positions));
    for (std::size_t i = 0; i < n; ++i)
      head_.base_positions.push_back(
          {{coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]}});
    LODE_TRY(const auto values,
             read_numbers(in, n, head_.shape.n_fields, head_.shape.has_narrow_values));
    head_.base_values.insert(head_.base_values.end(), values.begin(), values.end());
    return {};
  }
  Result<void> read_tetrahedra(StreamReader& in, std::size_t n) {
    const std::size_t first = head_.base.size();
    head_.base.resize(first + n);
    for (std::size_t corner = 0; corner < 4; ++corner) {
      LODE_TRY(const auto column, take_numbers(in, n));
      for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t v = column[i];
        if (v >= head_.shape.n_base_vertices && v != head_.outside())
          return fail("{}: expected vertices of the base, {}, or {}, got {}", in.what(),
                      head_.shape.n_base_vertices, head_.outside(), v);
        head_.base[first + i][corner] = v;
      }
    }
    LODE_TRY(const auto makers, take_numbers(in, n));
    for (const std::uint32_t maker : makers)
      if (maker >= head_.shape.n_nodes && maker != kNone)
        return fail("{}: expected one of {} nodes, got {}", in.what(), head_.shape.n_nodes, maker);
    head_.base_makers.insert(head_.base_makers.end(), makers.begin(), makers.end());
    LODE_CHECK(read_regions(in, n));
    return check_corners(in, first);
  }
  Result<void> read_regions(StreamReader& in, std::size_t n) {
    if (head_.shape.n_regions == 1) return {};
    LODE_TRY(const auto regions, take_numbers(in, n));
    for (const std::uint32_t region : regions)
      if (region >= head_.shape.n_regions)
        return fail("{}: expected one of {} regions, got {}", in.what(), head_.shape.n_regions,
                    region);
    head_.base_regions.insert(head_.base_regions.end(), regions.begin(), regions.end());
    return {};
  }
  Result<void> check_corners(const StreamReader& in, std::size_t first) const {
    for (std::size_t i = first; i < head_.base.size(); ++i) {
      Tetrahedron t = head_.base[i];
      std::ranges::sort(t);
      if (std::ranges::adjacent_find(t) != t.end())
        return fail("{}: expected tetrahedra of four vertices, got vertex {} twice", in.what(),
                    *std::ranges::adjacent_find(t));
    }
    return {};
  }
  Result<void> read_roots(StreamReader& in, std::size_t n) {
    LODE_TRY(const auto roots, take_numbers(in, n));
    for (const std::uint32_t root : roots) {
      if (root >= head_.shape.n_nodes || (!head_.roots.empty() && root <= head_.roots.back()))
        return fail("{}: expected nodes that ascend, up to {}, got {}", in.what(),
                    head_.shape.n_nodes, root);
      head_.roots.push_back(root);
    }
    return {};
  }

  const store::Reader& reader_;
  BaseCounts counts_;
  HierarchyHead& head_;
};

/// Where each page's blocks are: its links, then its fields.
Result<std::vector<std::size_t>> find_pages(const store::Reader& reader, const PageShape& shape) {
  std::vector<std::size_t> places;
  for (std::uint32_t page = 0; page < shape.n_pages(); ++page)
    for (std::uint32_t part = 0; part <= shape.n_fields; ++part) {
      const auto key = part == 0 ? key_of(Kind::links, page) : key_of(Kind::field, page, part - 1);
      const auto at = reader.find(key);
      if (!at) return fail("{}: expected {}, found none", reader.path(), store::describe(key));
      places.push_back(*at);
    }
  return places;
}

Result<PageContent> read_page(const store::Reader& reader, std::span<const std::size_t> blocks,
                              std::uint32_t number, const PageShape& shape) {
  PageContent content;
  for (std::size_t part = 0; part < blocks.size(); ++part) {
    LODE_TRY(const auto bytes, reader.read_block(blocks[part]));
    const std::string what =
        reader.path() + ": " + store::describe(reader.blocks()[blocks[part]].key);
    LODE_CHECK(part == 0 ? decode_links(bytes, what, number, shape, content)
                         : decode_field(bytes, what, part - 1, shape, content));
  }
  return content;
}

Result<std::vector<std::uint32_t>> read_gradients(const store::Reader& reader, std::uint32_t page,
                                                  const PageShape& shape) {
  const auto key = key_of(Kind::gradients, page);
  LODE_TRY(const auto bytes, read_block(reader, key));
  StreamReader in(bytes, reader.path() + ": " + store::describe(key));
  LODE_TRY(auto gradients, in.read_planes<std::uint32_t>(vertices_of(shape, page).n));
  LODE_CHECK(in.expect_end());
  return gradients;
}

}  // namespace

bool is_model_of(const std::string& path) {
  const auto reader = store::Reader::open(path);
  return reader && reader->model() == kModelName;
}

Result<OpenedHierarchy> open(const std::string& path) {
  LODE_TRY(auto opened, store::Reader::open(path));
  const auto reader = std::make_shared<const store::Reader>(std::move(opened));
  if (reader->model() != kModelName)
    return fail("{}: expected the model {}, got {}", path, kModelName, reader->model());
  BaseCounts counts;
  LODE_TRY(HierarchyHead head, decode_head(reader->metadata(), path, counts));
  LODE_CHECK(BaseReader(*reader, counts, head).run());
  LODE_TRY(auto places, find_pages(*reader, head.shape));
  const PageShape shape = head.shape;
  auto load = [reader, places = std::move(places), shape](std::uint32_t number) {
    const std::size_t n_parts = 1 + shape.n_fields;
    return read_page(*reader, std::span(places).subspan(number * n_parts, n_parts), number, shape);
  };
  auto gradients = [reader, shape](std::uint32_t page) {
    return read_gradients(*reader, page, shape);
  };
  return OpenedHierarchy{PackedHierarchy(std::move(head), std::move(load)), std::move(gradients),
                         [reader] {
                           return FileReads{reader->reads().n_bytes, reader->file_size()};
                         }};
}

}  // namespace lode::tetra_mt
