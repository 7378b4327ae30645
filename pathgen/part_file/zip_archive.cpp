#include "pathgen/part_file/zip_archive.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace tiltfeed::pathgen {
namespace {

constexpr std::uint32_t kEndMark = 0x06054b50, kEntryMark = 0x02014b50, kLocalMark = 0x04034b50;
constexpr std::uint32_t kLocatorMark = 0x07064b50, kWideEndMark = 0x06064b50, kWideField = 1;
constexpr std::size_t kLocatorBytes = 20, kWideEndBytes = 56;
constexpr std::size_t kEndBytes = 22, kEntryBytes = 46, kLocalBytes = 30, kMaxRemark = 0xffff;
constexpr std::uint32_t kEncrypted = 1, kStored = 0, kDeflated = 8, kZip64 = 0xffffffffu;

/// Little-endian. Requires: it is there.
std::uint32_t whole_at(std::span<const char> bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::uint64_t wide_at(std::span<const char> bytes, std::size_t at) {
  return whole_at(bytes, at, 4) | static_cast<std::uint64_t>(whole_at(bytes, at + 4, 4)) << 32;
}

struct Inflate {
  z_stream stream{};
  bool ready = ::inflateInit2(&stream, -MAX_WBITS) == Z_OK;
  ~Inflate() {
    if (ready) ::inflateEnd(&stream);
  }
};

}  // namespace

Result<ZipArchive> ZipArchive::open(std::span<const char> bytes, const std::string& file) {
  const auto broken = [&](const std::string& what) {
    return fail(Code::kInput, file + ": the ZIP archive " + what + "; export or copy the part again");
  };
  ZipArchive zip(bytes, file);
  if (bytes.size() < kEndBytes) return broken("is cut short");
  // The end may have a remark behind it.
  std::size_t end = bytes.size() - kEndBytes;
  const std::size_t last = end > kMaxRemark ? end - kMaxRemark : 0;
  while (whole_at(bytes, end, 4) != kEndMark ||
         end + kEndBytes + whole_at(bytes, end + 20, 2) != bytes.size()) {
    if (end == last) return broken("has no directory: it is cut short");
    --end;
  }
  std::uint64_t count = whole_at(bytes, end + 10, 2), directory = whole_at(bytes, end + 16, 4);
  const bool wide = end >= kLocatorBytes && whole_at(bytes, end - kLocatorBytes, 4) == kLocatorMark;
  if (wide) {
    const std::uint64_t record = wide_at(bytes, end - kLocatorBytes + 8);
    if (record > end || end - record < kWideEndBytes || whole_at(bytes, record, 4) != kWideEndMark)
      return broken("has a ZIP64 record that is not where it says");
    count = wide_at(bytes, record + 32), directory = wide_at(bytes, record + 48);
  } else if (whole_at(bytes, end + 4, 2) != 0 || whole_at(bytes, end + 6, 2) != 0) {
    return broken("is in several parts");
  }
  if (count > kMaxZipEntries)
    return fail(Code::kLimit, file + ": " + std::to_string(count) + " entries are over the limit of " +
                                  std::to_string(kMaxZipEntries));
  std::uint64_t at = directory;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (at > end || end - at < kEntryBytes || whole_at(bytes, at, 4) != kEntryMark)
      return broken("has a directory that is cut short");
    Entry entry;
    entry.flags = whole_at(bytes, at + 8, 2), entry.method = whole_at(bytes, at + 10, 2);
    entry.check_sum = whole_at(bytes, at + 16, 4);
    entry.packed = whole_at(bytes, at + 20, 4), entry.size = whole_at(bytes, at + 24, 4);
    entry.header = whole_at(bytes, at + 42, 4);
    const std::size_t name = whole_at(bytes, at + 28, 2);
    const std::size_t rest = name + whole_at(bytes, at + 30, 2) + whole_at(bytes, at + 32, 2);
    if (end - at - kEntryBytes < rest) return broken("has a directory that is cut short");
    // What does not fit into 32 bits stands behind the name, in this order.
    const std::size_t extra = at + kEntryBytes + name, extra_end = extra + whole_at(bytes, at + 30, 2);
    for (std::size_t field = extra; field + 4 <= extra_end; field += 4 + whole_at(bytes, field + 2, 2)) {
      if (whole_at(bytes, field, 2) != kWideField) continue;
      std::size_t value = field + 4;
      const std::size_t field_end = std::min(extra_end, value + whole_at(bytes, field + 2, 2));
      for (std::uint64_t* wanted : {&entry.size, &entry.packed, &entry.header})
        if (*wanted == kZip64 && value + 8 <= field_end) *wanted = wide_at(bytes, value), value += 8;
      break;
    }
    zip.entries_.insert_or_assign(std::string(bytes.data() + at + kEntryBytes, name), entry);
    at += kEntryBytes + rest;
  }
  return zip;
}

Result<std::string> ZipArchive::read(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return fail(Code::kInput, file_ + ": it has no entry " + name);
  const Entry& entry = found->second;
  const auto broken = [&](const std::string& what) {
    return fail(Code::kInput, file_ + ": entry " + name + " " + what + "; export or copy the part again");
  };
  if ((entry.flags & kEncrypted) != 0) return broken("is encrypted");
  if (entry.header > bytes_.size() || bytes_.size() - entry.header < kLocalBytes ||
      whole_at(bytes_, entry.header, 4) != kLocalMark)
    return broken("is not where the directory says");
  const std::uint64_t first = entry.header + kLocalBytes + whole_at(bytes_, entry.header + 26, 2) +
                              whole_at(bytes_, entry.header + 28, 2);
  if (first > bytes_.size() || bytes_.size() - first < entry.packed) return broken("is cut short");
  if (entry.size > kMaxInflated)
    return fail(Code::kLimit, file_ + ": entry " + name + " says " + std::to_string(entry.size) +
                                  " bytes, over the limit of " + std::to_string(kMaxInflated));
  const std::span<const char> packed = bytes_.subspan(first, entry.packed);
  Result<std::string> text = std::string();
  if (entry.method == kStored)
    text->assign(packed.begin(), packed.end());
  else if (entry.method == kDeflated)
    text = inflated(entry, packed, name);
  else
    return broken("is packed by method " + std::to_string(entry.method) + ", which is not read");
  if (!text) return text;
  if (text->size() != entry.size)
    return broken("has " + std::to_string(text->size()) + " bytes and says " + std::to_string(entry.size));
  const auto sum =
      ::crc32_z(::crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(text->data()), text->size());
  if (sum != entry.check_sum) return broken("has a wrong check sum");
  return text;
}

Result<std::string> ZipArchive::inflated(const Entry& entry, std::span<const char> packed,
                                         const std::string& name) const {
  const auto broken = [&] {
    return fail(Code::kInput, file_ + ": entry " + name +
                                  " is damaged: it cannot be inflated; export or copy the part again");
  };
  Inflate inflate;
  if (!inflate.ready) return fail(Code::kLimit, file_ + ": no memory to inflate " + name);
  std::string text;
  std::array<char, 64 * 1024> piece;
  z_stream& z = inflate.stream;
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  z.avail_in = static_cast<uInt>(packed.size());
  int state = Z_OK;
  while (state == Z_OK) {
    z.next_out = reinterpret_cast<Bytef*>(piece.data());
    z.avail_out = static_cast<uInt>(piece.size());
    state = ::inflate(&z, Z_NO_FLUSH);
    text.append(piece.data(), piece.size() - z.avail_out);
    // More than it says is damage, and what a bomb does.
    if (text.size() > entry.size) return broken();
  }
  if (state != Z_STREAM_END) return broken();
  return text;
}

}  // namespace tiltfeed::pathgen
