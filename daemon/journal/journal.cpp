#include "daemon/journal/journal.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace tiltfeed::daemon {

namespace {

constexpr std::uint32_t kRecordMark = 0x544A5231;  // "TJR1": format 1
constexpr std::uint32_t kEmptyMark = 0x544A5230;   // "TJR0"
constexpr std::size_t kNumberAt = 12;
constexpr std::uint16_t kElsewhere = 1;  // flag; earlier versions write 0 and do not look
/// A file of this size is replaced by its newest record: 10 million blocks stay within it.
constexpr std::uint64_t kMaxRecords = (8u << 20) / kRecordBytes;
/// Slots of a new file; a full one grows to twice as many, by no more than are written from little memory.
constexpr std::uint64_t kFirstSlots = 64, kMostSlotsAtOnce = 1024;

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

bool has_check_sum(std::string_view bytes) {
  if (bytes.size() != kRecordBytes) return false;
  Reader tail(bytes.data() + kRecordBytes - 4);
  return tail.number(4) == check_sum(bytes.data(), kRecordBytes - 4);
}

std::string empty_slots(std::uint64_t first, std::uint64_t last) {
  std::string bytes;
  bytes.reserve((last - first) * kRecordBytes);
  for (std::uint64_t slot = first; slot < last; ++slot) {
    const auto one = encode_empty(slot);
    bytes.append(one.data(), one.size());
  }
  return bytes;
}

bool is_possible(const RunRecord& r) {
  return r.executed <= r.acknowledged && r.acknowledged <= r.offered && r.offered <= r.reserved &&
         r.reserved <= r.total;
}

/// A journal holds one run: what is of another does not belong there.
bool same_run(const RunRecord& a, const RunRecord& b) {
  return a.run == b.run && a.job == b.job && a.total == b.total && a.program == b.program &&
         a.link == b.link && a.session_id == b.session_id;
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
  out.number(r.elsewhere ? kElsewhere : 0, 2);
  for (const std::uint64_t value : {number, r.run, r.job, r.total, r.reserved, r.offered, r.acknowledged,
                                    r.executed, static_cast<std::uint64_t>(r.wall_ms)})
    out.number(value, 8);
  out.raw(r.program);
  out.raw(r.host);
  out.number(check_sum(bytes.data(), kRecordBytes - 4), 4);
  return bytes;
}

std::optional<RunRecord> decode_record(std::string_view bytes, std::uint64_t number) {
  if (!has_check_sum(bytes)) return std::nullopt;
  Reader in(bytes.data());
  RunRecord r;
  if (in.number(4) != kRecordMark) return std::nullopt;
  const std::uint64_t event = in.number(1);
  if (event < static_cast<std::uint8_t>(RunEvent::kBegan) ||
      event > static_cast<std::uint8_t>(RunEvent::kToolChange))
    return std::nullopt;
  r.event = static_cast<RunEvent>(event);
  r.link = static_cast<std::uint8_t>(in.number(1));
  r.session_id = static_cast<std::uint16_t>(in.number(2));
  r.boot_id = static_cast<std::uint16_t>(in.number(2));
  r.elsewhere = (in.number(2) & kElsewhere) != 0;
  if (in.number(8) != number) return std::nullopt;
  for (std::uint64_t* value :
       {&r.run, &r.job, &r.total, &r.reserved, &r.offered, &r.acknowledged, &r.executed})
    *value = in.number(8);
  r.wall_ms = static_cast<std::int64_t>(in.number(8));
  in.raw(r.program);
  in.raw(r.host);
  if (!is_possible(r)) return std::nullopt;
  return r;
}

std::array<char, kRecordBytes> encode_empty(std::uint64_t number) {
  std::array<char, kRecordBytes> bytes{};
  Writer(bytes.data()).number(kEmptyMark, 4);
  Writer(bytes.data() + kNumberAt).number(number, 8);
  Writer(bytes.data() + kRecordBytes - 4).number(check_sum(bytes.data(), kRecordBytes - 4), 4);
  return bytes;
}

bool is_empty(std::string_view bytes, std::uint64_t number) {
  const auto empty = encode_empty(number);
  return bytes == std::string_view(empty.data(), empty.size());
}

JournalContent read_journal(std::string_view bytes) {
  JournalContent content;
  std::uint64_t unknown = 0;
  for (std::uint64_t slot = 0; slot * kRecordBytes < bytes.size(); ++slot) {
    const std::string_view place = bytes.substr(slot * kRecordBytes, kRecordBytes);
    std::optional<RunRecord> record = decode_record(place, slot);
    if (!record || (content.last && !same_run(*content.last, *record))) {
      // What stands behind an empty slot was never made durable: that slot would have been before.
      if (is_empty(place, slot))
        content.ended = true;
      else if (++unknown; !content.ended)
        ++content.lost;
      continue;
    }
    if (content.last) {
      // Figures only grow: a record that a damaged disk left behind cannot take any back.
      record->reserved = std::max(record->reserved, content.last->reserved);
      record->offered = std::max(record->offered, content.last->offered);
      record->acknowledged = std::max(record->acknowledged, content.last->acknowledged);
      record->executed = std::max(record->executed, content.last->executed);
      record->elsewhere = record->elsewhere || content.last->elsewhere;
    }
    content = {*record, slot + 1, unknown, 0, false};
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
  journal.slots_ = bytes->size() / kRecordBytes;
  return journal;
}

Result<void> Journal::start_with(const RunRecord& record) {
  if (error_) return tl::unexpected<Error>(*error_);
  const auto bytes = encode_record(record, 0);
  if (const int replaced =
          disk_.replace(std::string(bytes.data(), bytes.size()) + empty_slots(1, kFirstSlots));
      replaced < 0)
    return broken("begun", replaced);
  content_ = {record, 1, 0, 0, true};
  slots_ = kFirstSlots;
  return {};
}

/// So that an empty slot stands behind the next record.
Result<void> Journal::make_room() {
  if (content_.records + 1 < slots_) return {};
  const std::uint64_t more = slots_ + std::min(slots_, kMostSlotsAtOnce);
  const std::string bytes = empty_slots(slots_, more);
  const std::ptrdiff_t written = disk_.write(slots_ * kRecordBytes, bytes);
  if (written != static_cast<std::ptrdiff_t>(bytes.size())) return broken("made larger", written);
  slots_ = more;
  return sync();
}

Result<void> Journal::append(const RunRecord& record) {
  if (error_) return tl::unexpected<Error>(*error_);
  if (!content_.whole() || content_.records >= kMaxRecords) return start_with(record);
  if (const Result<void> room = make_room(); !room) return room;
  const auto bytes = encode_record(record, content_.records);
  const std::ptrdiff_t written = disk_.write(content_.records * kRecordBytes, {bytes.data(), bytes.size()});
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

}  // namespace tiltfeed::daemon
