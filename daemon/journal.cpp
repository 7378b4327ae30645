#include "daemon/journal.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace tiltfeed {

namespace {

constexpr std::uint32_t kRecordMark = 0x544A5231;  // "TJR1": format 1
/// A file of this size is replaced by its newest record: 10 million blocks stay within it.
constexpr std::uint64_t kMaxRecords = (8u << 20) / kRecordBytes;

/// Little-endian fields, one after the other.
class Writer {
 public:
  explicit Writer(char* out) : out_(out) {}
  void number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) *out_++ = static_cast<char>(value >> (8 * i) & 0xFF);
  }
  template <std::size_t n>
  void raw(const std::array<std::uint8_t, n>& bytes) {
    std::memcpy(out_, bytes.data(), n);
    out_ += n;
  }

 private:
  char* out_;
};

class Reader {
 public:
  explicit Reader(const char* in) : in_(in) {}
  std::uint64_t number(int bytes) {
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) value |= std::uint64_t{static_cast<unsigned char>(*in_++)} << (8 * i);
    return value;
  }
  template <std::size_t n>
  void raw(std::array<std::uint8_t, n>& bytes) {
    std::memcpy(bytes.data(), in_, n);
    in_ += n;
  }

 private:
  const char* in_;
};

std::uint32_t check_sum(const char* bytes, std::size_t count) {
  return static_cast<std::uint32_t>(
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes), static_cast<uInt>(count)));
}

}  // namespace

std::array<char, kRecordBytes> encode_record(const RunRecord& r, std::uint64_t number) {
  std::array<char, kRecordBytes> bytes{};
  Writer out(bytes.data());
  out.number(kRecordMark, 4);
  out.number(static_cast<std::uint8_t>(r.event), 1);
  out.number(r.link, 1);
  out.number(r.session_id, 2);
  out.number(r.boot_id, 2);
  out.number(0, 2);
  for (const std::uint64_t value : {number, r.run, r.job, r.total, r.reserved, r.offered, r.acknowledged,
                                    r.executed, static_cast<std::uint64_t>(r.wall_ms)})
    out.number(value, 8);
  out.raw(r.program);
  out.raw(r.host);
  out.number(check_sum(bytes.data(), kRecordBytes - 4), 4);
  return bytes;
}

std::optional<RunRecord> decode_record(std::string_view bytes, std::uint64_t number) {
  if (bytes.size() != kRecordBytes) return std::nullopt;
  Reader tail(bytes.data() + kRecordBytes - 4);
  if (tail.number(4) != check_sum(bytes.data(), kRecordBytes - 4)) return std::nullopt;
  Reader in(bytes.data());
  RunRecord r;
  if (in.number(4) != kRecordMark) return std::nullopt;
  const std::uint64_t event = in.number(1);
  if (event < static_cast<std::uint8_t>(RunEvent::kBegan) ||
      event > static_cast<std::uint8_t>(RunEvent::kFault))
    return std::nullopt;
  r.event = static_cast<RunEvent>(event);
  r.link = static_cast<std::uint8_t>(in.number(1));
  r.session_id = static_cast<std::uint16_t>(in.number(2));
  r.boot_id = static_cast<std::uint16_t>(in.number(2));
  in.number(2);
  if (in.number(8) != number) return std::nullopt;
  for (std::uint64_t* value :
       {&r.run, &r.job, &r.total, &r.reserved, &r.offered, &r.acknowledged, &r.executed})
    *value = in.number(8);
  r.wall_ms = static_cast<std::int64_t>(in.number(8));
  in.raw(r.program);
  in.raw(r.host);
  return r;
}

JournalContent read_journal(std::string_view bytes) {
  JournalContent content;
  std::uint64_t damaged = 0;
  for (std::uint64_t slot = 0; (slot + 1) * kRecordBytes <= bytes.size(); ++slot) {
    std::optional<RunRecord> record = decode_record(bytes.substr(slot * kRecordBytes, kRecordBytes), slot);
    if (!record) {
      ++damaged;
      continue;
    }
    // Figures only grow within a run: a record that a damaged disk left behind cannot take any back.
    if (content.last && content.last->run == record->run) {
      record->reserved = std::max(record->reserved, content.last->reserved);
      record->offered = std::max(record->offered, content.last->offered);
      record->acknowledged = std::max(record->acknowledged, content.last->acknowledged);
      record->executed = std::max(record->executed, content.last->executed);
    }
    content.last = *record;
    content.records = slot + 1;
    content.damaged = damaged;
  }
  return content;
}

tl::unexpected<Error> Journal::broken(const char* what, std::ptrdiff_t code) {
  const std::string reason = code < 0 ? std::strerror(static_cast<int>(-code)) : "the disk is full";
  error_ = {Code::kIo, disk_.name + ": the journal cannot be " + what + ": " + reason +
                           "; nothing is sent without a journal: make room or replace the disk"};
  return tl::unexpected<Error>(*error_);
}

Result<Journal> Journal::open(JournalDisk disk) {
  Journal journal(std::move(disk));
  const Result<std::string> bytes = journal.disk_.read();
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  journal.content_ = read_journal(*bytes);
  const std::uint64_t whole = journal.content_.records * kRecordBytes;
  if (bytes->size() > whole) {
    if (const int cut = journal.disk_.truncate(whole); cut < 0)
      return journal.broken("cut to its whole part", cut);
  }
  if (const Result<void> synced = journal.sync(); !synced) return tl::unexpected<Error>(synced.error());
  return journal;
}

Result<void> Journal::append(const RunRecord& record) {
  if (error_) return tl::unexpected<Error>(*error_);
  if (content_.records >= kMaxRecords) {
    const auto bytes = encode_record(record, 0);
    if (const int replaced = disk_.replace({bytes.data(), bytes.size()}); replaced < 0)
      return broken("shortened", replaced);
    content_ = {record, 1, 0};
    return {};
  }
  const auto bytes = encode_record(record, content_.records);
  const std::ptrdiff_t written = disk_.append({bytes.data(), bytes.size()});
  if (written != static_cast<std::ptrdiff_t>(kRecordBytes)) return broken("written", written);
  content_.last = record;
  ++content_.records;
  return {};
}

Result<void> Journal::sync() {
  if (error_) return tl::unexpected<Error>(*error_);
  if (const int synced = disk_.sync(); synced < 0) return broken("made durable", synced);
  return {};
}

}  // namespace tiltfeed
