#pragma once
// The journal of one run: what was handed to the wire, taken over and executed. Records of one size, one
// after the other, each with its own check sum and the whole state of its run, so that any record that is
// whole can be believed by itself. Behind the newest one stand empty slots with check sums of their own, so
// that a file that was cut off, or whose end was lost or damaged, is never taken for a whole one.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

using Sha256 = std::array<std::uint8_t, 32>;
using HostBoot = std::array<std::uint8_t, 16>;

enum class RunEvent : std::uint8_t {
  kBegan = 1,   ///< nothing was sent yet
  kStreaming,   ///< figures as they grow
  kExecuted,    ///< every block is proved to be executed
  kStopped,     ///< by the operator or the service, in order
  kFault,       ///< link, controller or file
  kToolChange,  ///< the machine stands before a tool change: all before it is executed, nothing after it has
                ///< left
};

/// Properties: 1 executed <= acknowledged <= offered <= reserved <= total. 2 No block after `offered` was
/// given to the wire while this host ran. 3 None after `reserved` was, even if the host lost power.
struct RunRecord {
  RunEvent event = RunEvent::kBegan;
  std::uint8_t link = 0;                      ///< LinkKind
  bool elsewhere = false;                     ///< the axes were read, and not where the executed blocks lead
  std::uint16_t session_id = 0, boot_id = 0;  ///< of the controller; 0: not known (yet)
  std::uint64_t run = 0;                      ///< 1, 2, ... within the journal
  std::uint64_t job = 0;
  std::uint64_t total = 0;  ///< blocks of the program
  std::uint64_t reserved = 0, offered = 0, acknowledged = 0, executed = 0;
  std::int64_t wall_ms = 0;  ///< since 1970, for people: no decision looks at it
  Sha256 program{};          ///< of the file
  HostBoot host{};           ///< of the running kernel; another one: the host was off in between
  bool operator==(const RunRecord&) const = default;
};

inline constexpr std::size_t kRecordBytes = 136;
/// `number` counts the records of the file from 0; it is part of what the check sum covers.
std::array<char, kRecordBytes> encode_record(const RunRecord& record, std::uint64_t number);
/// Nothing when the bytes are not a whole, undamaged record with that number, or when its figures contradict
/// each other.
std::optional<RunRecord> decode_record(std::string_view bytes, std::uint64_t number);
/// A slot that waits for its record.
std::array<char, kRecordBytes> encode_empty(std::uint64_t number);
bool is_empty(std::string_view bytes, std::uint64_t number);

/// The few file operations that a journal needs. Negative results are -errno.
struct JournalDisk {
  std::function<Result<std::string>()> read;  ///< the whole file
  /// Bytes written, perhaps fewer than given.
  std::function<std::ptrdiff_t(std::uint64_t at, std::string_view)> write;
  std::function<int()> sync;                             ///< what was written survives a power loss
  std::function<int(std::string_view content)> replace;  ///< the whole file, at once and durably
  std::string name;                                      ///< for messages
};
/// A file, made when it is not there, locked against a second process. Errors: kIo.
Result<JournalDisk> journal_file(const std::string& path);

/// What the bytes of a journal hold.
struct JournalContent {
  std::optional<RunRecord> last;  ///< the newest whole record; figures are the largest of its run
  std::uint64_t records = 0;      ///< slots up to and with the newest whole record
  std::uint64_t damaged = 0;      ///< slots among these that are neither whole nor empty
  std::uint64_t lost = 0;         ///< such slots after the newest: newer records may have stood there
  bool ended = false;             ///< an empty slot follows: the file was not cut off
  bool whole() const { return last && damaged == 0 && lost == 0 && ended; }
};
JournalContent read_journal(std::string_view bytes);
/// Nothing in it where there is no file, or none that can be read. Errors: kIo: another process has it.
Result<JournalContent> read_journal_file(const std::string& path);

/// Properties: 1 what is not whole is replaced at once by the next record, never mended in between. 2 After
/// an error nothing is written any more, because what the disk then holds is not known.
class Journal {
 public:
  /// Errors: kIo.
  static Result<Journal> open(JournalDisk disk);
  const JournalContent& content() const { return content_; }

  /// The file then holds nothing else, durably. Errors: kIo.
  Result<void> start_with(const RunRecord& record);
  /// Not durable before `sync`; a process that is killed after it loses nothing. Errors: kIo.
  Result<void> append(const RunRecord& record);
  /// Errors: kIo.
  Result<void> sync();

 private:
  explicit Journal(JournalDisk disk) : disk_(std::move(disk)) {}
  Result<void> make_room();
  tl::unexpected<Error> broken(const char* what, std::ptrdiff_t code);

  JournalDisk disk_;
  JournalContent content_;
  std::uint64_t slots_ = 0;  ///< of the file
  std::optional<Error> error_;
};

}  // namespace tiltfeed::daemon
