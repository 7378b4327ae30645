#include "pathgen/mesh/stl.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include "pathgen/mesh/file_descriptor.h"
#include "pathgen/mesh/fresh_memory.h"
#include "pathgen/mesh/obj_text.h"
#include "pathgen/mesh/ply.h"
#include "pathgen/mesh/stl_layout.h"
#include "pathgen/mesh/stl_text.h"

namespace tiltfeed::pathgen {
namespace {

/// Fewer bytes after the last record than one more record would need can hide no facet.
constexpr std::uint64_t kMaxTrailingBytes = kRecordBytes - 1;

using Range = tbb::blocked_range<std::uint64_t>;
/// Facets that a task takes at a time: some ten microseconds of work, and what they need fits the processor's
/// cache.
constexpr std::uint64_t kFacetsPerTask = 2048;

std::uint32_t facet_count(std::span<const char> bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes, sizeof count);
  return count;
}

Result<void> check_input(std::uint64_t size, const std::string& name, double unit_mm) {
  if (!std::isfinite(unit_mm) || unit_mm <= 0.0) {
    return fail(Code::kInput, name + ": a unit of " + number_text(unit_mm, 7) +
                                  " mm is not a length; give the length of the file's unit in mm");
  }
  if (size == 0) return fail(Code::kInput, name + ": the file is empty; export the part again");
  if (size > kMaxStlBytes) {
    return fail(Code::kLimit, name + ": " + std::to_string(size) + " bytes are over the limit of " +
                                  std::to_string(kMaxStlBytes) + "; export with a coarser tolerance");
  }
  return {};
}

/// Why bytes that are neither ASCII STL nor a binary STL of the right size are refused.
tl::unexpected<Error> misfit(std::span<const char> bytes, const std::string& name) {
  const std::uint64_t size = bytes.size();
  const std::string not_stl =
      name + ": this is no STL, OBJ or PLY file: no text that begins with \"solid\", and ";
  if (size < kDataStart) {
    return fail(Code::kInput, not_stl + "its " + std::to_string(size) +
                                  " bytes are fewer than the 84 of a binary header; export the part again");
  }
  const std::uint64_t count = facet_count(bytes);
  const std::uint64_t whole = (size - kDataStart) / kRecordBytes;
  const std::uint64_t over = (size - kDataStart) % kRecordBytes;
  if (count > kMaxFacets && whole < kMaxFacets) {
    return fail(Code::kInput, not_stl + "bytes 80 to 83 would mean " + std::to_string(count) +
                                  " facets in a file of " + std::to_string(size) +
                                  " bytes; export the part again as STL");
  }
  const std::string found = std::to_string(count) + " facets (" +
                            std::to_string(kDataStart + count * kRecordBytes) + " bytes), but the file is " +
                            std::to_string(size) + " bytes: " + std::to_string(whole) + " whole facets and " +
                            std::to_string(over) + " bytes";
  return fail(Code::kInput, name + ": the binary header says " + found +
                                (count > whole ? "; the file is cut short or its count is too high"
                                               : "; its count is too low") +
                                "; export or copy the part again");
}

/// Facets that may not stay, and the first of them.
struct Refused {
  std::uint64_t count = 0, first = 0;
  void add(std::uint64_t facet) {
    if (count++ == 0) first = facet;
  }
  /// Of the facets after these.
  void add(const Refused& later) {
    if (count == 0) first = later.first;
    count += later.count;
  }
};

/// Scales to mm and checks every coordinate. `fill(first, last)` puts those facets where they belong before
/// that, while they are in the processor's cache.
template <class Fill>
Result<Stl> scaled(Stl stl, const std::string& name, double unit_mm, const Fill& fill) {
  const auto beyond = [](Point<Part> p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kMaxCoordinate;
  };
  struct Findings {
    Refused not_finite, too_far;
  };
  const auto look = [&](std::uint64_t first, std::uint64_t last, Findings& found) {
    fill(stl.facets, first, last);
    for (std::uint64_t i = first; i < last; ++i) {
      std::array<Point<Part>, 3>& facet = stl.facets[i];
      const bool finite = std::all_of(facet.begin(), facet.end(), [](Point<Part> p) { return is_finite(p); });
      for (Point<Part>& p : facet) p = {p.x * unit_mm, p.y * unit_mm, p.z * unit_mm};
      if (!finite)
        found.not_finite.add(i);
      else if (std::any_of(facet.begin(), facet.end(), beyond))
        found.too_far.add(i);
    }
  };
  const auto [not_finite, too_far] = tbb::parallel_reduce(
      Range(0, stl.facets.size(), kFacetsPerTask), Findings{},
      [&](const Range& range, Findings found) {
        for (std::uint64_t i = range.begin(); i < range.end(); i += kFacetsPerTask)
          look(i, std::min(range.end(), i + kFacetsPerTask), found);
        return found;
      },
      [](Findings a, const Findings& b) {
        a.not_finite.add(b.not_finite), a.too_far.add(b.too_far);
        return a;
      });
  if (not_finite.count > 0) {
    return fail(Code::kMesh, name + ": " + std::to_string(not_finite.count) +
                                 " facets have NaN or infinite coordinates, the first is facet " +
                                 std::to_string(not_finite.first) + "; repair the part and export it again");
  }
  if (too_far.count > 0) {
    const std::array<Point<Part>, 3>& facet = stl.facets[too_far.first];
    const Point<Part> far_corner = *std::find_if(facet.begin(), facet.end(), beyond);
    return fail(Code::kMesh, name + ": " + std::to_string(too_far.count) +
                                 " facets lie beyond the limit of " + number_text(kMaxCoordinate, 7) +
                                 " mm, the first is facet " + std::to_string(too_far.first) + " at " +
                                 to_string(far_corner) + " mm with a unit of " + number_text(unit_mm, 7) +
                                 " mm; check the unit of the file, or move the part to its origin");
  }
  return stl;
}

/// Four bytes of text as a count are over 150 million facets, more than kMaxStlBytes holds, so that no text
/// can satisfy this, while many binary headers begin with "solid".
bool is_binary(std::uint64_t size, std::uint32_t count) {
  const std::uint64_t end = kDataStart + count * kRecordBytes;
  return size >= end && size - end <= kMaxTrailingBytes;
}

/// `records(first, last, place)`: where the bytes of those records are, which may be put into `place`.
/// Requires: is_binary().
template <class Records>
Result<Stl> parse_binary(std::uint64_t size, std::uint32_t count, const std::string& name, double unit_mm,
                         const Records& records) {
  if (count == 0) {
    return fail(Code::kInput, name + ": the binary header says 0 facets; export the part again");
  }
  if (count > kMaxFacets) {
    return fail(Code::kLimit, name + ": " + std::to_string(count) + " facets are over the limit of " +
                                  std::to_string(kMaxFacets) + "; export with a coarser tolerance");
  }
  Stl stl;
  stl.binary = true;
  resize_side_by_side(stl.facets, count);
  const std::uint64_t trailing = size - kDataStart - count * kRecordBytes;
  if (trailing > 0) {
    stl.warnings.push_back(name + ": " + std::to_string(trailing) +
                           " bytes after the last facet are ignored");
  }
  return scaled(std::move(stl), name, unit_mm, [&](auto& facets, std::uint64_t first, std::uint64_t last) {
    std::array<char, kFacetsPerTask * kRecordBytes> place;
    const char* record = records(first, last, place.data());
    for (std::uint64_t i = first; i < last; ++i, record += kRecordBytes) {
      float c[9];
      std::memcpy(c, record + kNormalBytes, sizeof c);
      facets[i] = {{{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}}};
    }
  });
}

/// False, and errno (EIO where the file ends before them), if the bytes cannot be read.
bool read_at(int fd, std::uint64_t at, std::span<char> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(fd, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = EIO;
    if (got <= 0) return false;
    at += static_cast<std::uint64_t>(got);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

Result<Stl> parse_stl(std::span<const char> bytes, const std::string& name, double unit_mm) {
  if (auto good = check_input(bytes.size(), name, unit_mm); !good) return tl::unexpected(good.error());
  const std::string_view text(bytes.data(), bytes.size());
  if (bytes.size() >= kDataStart && is_binary(bytes.size(), facet_count(bytes)))
    return parse_binary(bytes.size(), facet_count(bytes), name, unit_mm,
                        [&](std::uint64_t first, std::uint64_t, char*) {
                          return bytes.data() + kDataStart + first * kRecordBytes;
                        });
  const auto facets = [&](Result<Polygons> polygons) -> Result<Stl> {
    if (!polygons) return tl::unexpected(polygons.error());
    return facets_of(std::move(*polygons), name, unit_mm);
  };
  const bool ply = looks_like_ply(bytes), words = looks_like_text_stl(text);
  if (!ply && !words && !looks_like_obj(text)) return misfit(bytes, name);
  Result<Stl> stl = ply     ? facets(parse_ply(bytes, name))
                    : words ? parse_text_stl(text, name)
                            : facets(parse_obj(text, name));
  if (!stl) return stl;
  return scaled(std::move(*stl), name, unit_mm, [](const auto&, std::uint64_t, std::uint64_t) {});
}

Result<Stl> read_stl(const std::string& path, double unit_mm) {
  // O_NONBLOCK: a FIFO must be refused below, not waited for.
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) return io_error(path, "cannot open");
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return io_error(path, "cannot read");
  if (!S_ISREG(info.st_mode)) return fail(Code::kIo, path + ": cannot read: not a regular file");
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (auto good = check_input(size, path, unit_mm); !good) return tl::unexpected(good.error());
  char head[kDataStart];
  if (read_at(file.get(), 0, head) && is_binary(size, facet_count(head))) {
    // Records go straight to facets: a copy of the whole file in memory would cost as much as they do.
    std::atomic<int> error = 0;
    auto stl = parse_binary(size, facet_count(head), path, unit_mm,
                            [&](std::uint64_t first, std::uint64_t last, char* place) {
                              const std::span bytes(place, (last - first) * kRecordBytes);
                              if (!read_at(file.get(), kDataStart + first * kRecordBytes, bytes))
                                error = errno;
                              return place;
                            });
    if (error == 0) return stl;
    errno = error;
    return io_error(path, "cannot read");
  }
  const auto buffer = std::make_unique_for_overwrite<char[]>(size);
  if (!read_at(file.get(), 0, {buffer.get(), size})) return io_error(path, "cannot read");
  return parse_stl({buffer.get(), size}, path, unit_mm);
}

}  // namespace tiltfeed::pathgen
