#include "sim/controller/modbus_controller.h"

#include <zlib.h>

#include <algorithm>
#include <cassert>

namespace tiltfeed::sim {
namespace {

// Words per unit; as kPositionScale.
constexpr double kFeedScale = 1e3;  // 1/min, mm/min, s of a dwell, rpm
constexpr std::uint16_t kEndOfProgram = 1;
constexpr std::uint16_t kInverseTime = 1 << 8, kMachinePlace = 1 << 14;
constexpr int kFirstKept = 9;  // of five bits, X Y Z tilt rotary: the axis stays where it is
constexpr std::uint16_t kKept = 0b11111 << kFirstKept;
constexpr std::uint16_t kSoftLimit = 2, kResetInMotion = 3;  // alarms
constexpr int kLeastPercent = 10, kMostPercent = 200;        // of an override
constexpr std::uint32_t kLargestMCode = 99;

std::uint32_t pair(std::span<const std::uint16_t> words, std::size_t at) {
  return static_cast<std::uint32_t>(words[at]) << 16 | words[at + 1];
}

double scaled_position(std::span<const std::uint16_t> words, std::size_t at) {
  return static_cast<std::int32_t>(pair(words, at)) / kPositionScale;
}

/// How far `seq` is ahead of `of`, modulo 2^16: -32768 .. 32767.
std::int16_t ahead(std::uint16_t seq, std::uint16_t of) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(seq - of));
}

}  // namespace

std::uint32_t crc_of_words(std::span<const std::uint16_t> words) {
  uLong crc = crc32(0L, Z_NULL, 0);
  std::array<Bytef, 64> bytes{};
  while (!words.empty()) {
    const std::span<const std::uint16_t> part = words.first(std::min(words.size(), bytes.size() / 2));
    for (std::size_t i = 0; i < part.size(); ++i) {
      bytes[2 * i] = static_cast<Bytef>(part[i] >> 8);
      bytes[2 * i + 1] = static_cast<Bytef>(part[i] & 0xFF);
    }
    crc = crc32(crc, bytes.data(), static_cast<uInt>(2 * part.size()));
    words = words.subspan(part.size());
  }
  return static_cast<std::uint32_t>(crc);
}

ModbusController::ModbusController(const MachineModel& machine, const Setup& setup,
                                   const ModbusOptions& options, Motion::Sink sink)
    : options_(options),
      sink_(std::move(sink)),
      motion_(
          machine, setup, std::clamp<std::size_t>(options.ring, 1, 0x7FFF),
          [this](const TraceRow& row) { executed(row); }, options.motion),
      planned_(motion_.position()),
      boot_id_(options.boot_id) {}

Access ModbusController::write(std::uint16_t address, Words words) {
  switch (address) {
    case kWindowAt:
      if (words.size() != kWindowWords) return Access::kIllegalValue;
      take_window(words);
      return Access::kOk;
    case kMailboxAt:
      if (words.size() != kMailboxWords) return Access::kIllegalValue;
      take_mailbox(words);
      return Access::kOk;
    case kHeartbeatAt:
      if (words.size() != 1) return Access::kIllegalValue;
      take_heartbeat(words[0]);
      return Access::kOk;
    default:
      return Access::kIllegalAddress;
  }
}

void ModbusController::refuse(Nack nack, std::uint16_t seq) {
  nack_ = nack;
  nack_seq_ = seq;
  ++rejected_;
}

/// Rule (b): acts only when CRC and session match; accepted numbers are passed over, a gap changes nothing.
void ModbusController::take_window(Words words) {
  const std::uint16_t first = words[1], count = words[2];
  std::array<std::uint16_t, kWindowWords - 2> guarded{};
  std::copy_n(words.begin(), 4, guarded.begin());
  std::copy(words.begin() + kWindowHeaderWords, words.end(), guarded.begin() + 4);
  if (crc_of_words(guarded) != pair(words, 4)) return refuse(Nack::kCrc, first);
  if (session_ == 0 || spent_ || words[0] != session_) return refuse(Nack::kSession, first);
  if (count < 1 || count > kBlocksPerWindow || (words[3] & ~kEndOfProgram) != 0)
    return refuse(Nack::kBadBlock, first);
  if (alarm_ != 0) return;  // the status says so
  if (ahead(first, last_accepted_) > 1) return refuse(Nack::kGap, first);

  const auto block = [&](int k) {
    return words.subspan(kWindowHeaderWords + static_cast<std::size_t>(k) * kBlockWords, kBlockWords);
  };
  for (int k = 0; k < count; ++k) {
    const auto seq = static_cast<std::uint16_t>(first + k);
    if (block(k)[0] != seq || (ahead(seq, last_accepted_) > 0 && !decode(block(k))))
      return refuse(Nack::kBadBlock, seq);
  }
  nack_ = Nack::kNone;
  nack_seq_ = 0;
  for (int k = 0; k < count; ++k)
    if (ahead(block(k)[0], last_accepted_) > 0 && !append(block(k))) return;
  const auto last = static_cast<std::uint16_t>(first + count - 1);
  if (words[3] == kEndOfProgram && last == last_accepted_) end_seq_ = last;
  note_end();
}

void ModbusController::note_end() {
  if (done_ || !end_seq_ || *end_seq_ != last_completed_) return;
  done_ = true;
  ++programs_;
}

/// False when the ring is full or the block raised an alarm.
bool ModbusController::append(Words words) {
  if (motion_.free_slots() == 0) return false;
  std::optional<Block> block = decode(words);
  assert(block);
  const MachineModel& machine = motion_.machine();
  if ((words[1] >> (kFirstKept + 3) & 1) == 0)
    block->target.a = turned_to(machine.tilt.word, block->target.a, planned_.a);
  if ((words[1] >> (kFirstKept + 4) & 1) == 0)
    block->target.c = turned_to(machine.rotary.word, block->target.c, planned_.c);
  if (motion_.outside(block->target)) {
    forget_blocks();
    alarm_ = kSoftLimit;
    return false;
  }
  last_accepted_ = words[0];
  planned_ = block->target;
  done_ = false;
  end_seq_.reset();
  seqs_.push_back(words[0]);
  if (seqs_.size() == 1 && !motion_.held()) last_started_ = words[0];
  motion_.push(*block);
  motion_.advance(motion_.now());  // blocks that take no time
  return true;
}

std::optional<Block> ModbusController::decode(Words words) const {
  const std::uint16_t op = words[1] & 0xFF, flags = words[1] & 0xFF00;
  const std::uint32_t f = pair(words, 14);
  Block block;
  block.line = pair(words, 2);
  block.target = planned_;
  if (op < static_cast<std::uint16_t>(Op::kRapid) || op > static_cast<std::uint16_t>(Op::kMCode))
    return std::nullopt;
  block.op = static_cast<Op>(op);
  // This machine has no tool centre control, so the TCP flag is refused with the unknown ones.
  if ((flags & ~(kInverseTime | kKept | kMachinePlace)) != 0) return std::nullopt;
  if ((flags & kInverseTime) != 0 && block.op != Op::kFeed) return std::nullopt;
  if ((flags & (kKept | kMachinePlace)) != 0 && block.op != Op::kRapid) return std::nullopt;
  if (block.op == Op::kMCode) {
    if (pair(words, 4) > kLargestMCode) return std::nullopt;
    block.m_code = static_cast<int>(pair(words, 4));
    block.spindle = f / kFeedScale;
    return block;
  }
  block.feed = f / kFeedScale;
  if (block.op == Op::kDwell) return block;
  if ((block.op == Op::kFeed) == (f == 0)) return std::nullopt;  // a feed move has F, a rapid has none
  block.inverse_time = flags == kInverseTime;
  double* const axes[] = {&block.target.x, &block.target.y, &block.target.z, &block.target.a,
                          &block.target.c};
  for (int axis = 0; axis < 5; ++axis) {
    if ((flags >> (kFirstKept + axis) & 1) != 0) continue;
    // Of machine coordinates only Z is known: 0 is the end of its travel.
    if ((flags & kMachinePlace) != 0 && axis != 2) return std::nullopt;
    *axes[axis] = scaled_position(words, 4 + 2 * static_cast<std::size_t>(axis));
    if ((flags & kMachinePlace) != 0) block.target.z += motion_.machine().z.max;
  }
  return block;
}

/// Motion's sink: keeps the sequence numbers in step.
void ModbusController::executed(const TraceRow& row) {
  last_completed_ = last_started_ = seqs_.front();
  seqs_.pop_front();
  const bool waits = row.command.op == Op::kMCode && row.command.m_code == 0;
  if (!seqs_.empty() && !waits) last_started_ = seqs_.front();
  note_end();
  sink_(row);
}

void ModbusController::take_mailbox(Words words) {
  if (crc_of_words(words.first(5)) != pair(words, 5)) return;  // not acknowledged: the host sends it again
  const std::uint16_t cmd_seq = words[1];
  if (cmd_seq == cmd_ack_) return;
  const bool done = execute(static_cast<Command>(words[2]), words[0], pair(words, 3));
  cmd_ack_ = cmd_seq;
  cmd_result_ = done ? 0 : 1;
}

bool ModbusController::execute(Command command, std::uint16_t session, std::uint32_t argument) {
  if (command == Command::kOpen) return open(session);
  if (session != session_) return false;
  switch (command) {
    case Command::kOpen:
      return false;
    case Command::kHold:
      if (session_ == 0 || alarm_ != 0) return false;
      motion_.hold();
      return true;
    case Command::kResume: {
      const std::optional<double> deadline = watchdog_at();
      if (session_ == 0 || alarm_ != 0 || (deadline && *deadline <= link_now_)) return false;
      motion_.resume();
      if (!seqs_.empty()) last_started_ = seqs_.front();
      motion_.advance(motion_.now());
      return true;
    }
    case Command::kStop:
      forget_blocks();
      return true;
    case Command::kReset:
      reset();
      return true;
    case Command::kOverride:
      if (argument < kLeastPercent || argument > kMostPercent) return false;
      motion_.set_feed_override(static_cast<int>(argument));
      return true;
    case Command::kClearAlarm:
      alarm_ = 0;
      return true;
    case Command::kClose:
      if (session_ == 0 || !motion_.idle()) return false;
      session_ = 0;
      heartbeat_seen_ = done_ = false;
      return true;
  }
  return false;
}

/// A new session starts its numbers at 1; opening the present one again changes nothing.
bool ModbusController::open(std::uint16_t session) {
  if (session == 0) return false;
  if (session == session_) return true;
  if (!motion_.idle() || alarm_ != 0) return false;
  motion_.stop();  // ends a hold that the session before left behind
  session_ = session;
  spent_ = false;
  last_accepted_ = last_started_ = last_completed_ = 0;
  end_seq_.reset();
  done_ = heartbeat_seen_ = false;
  nack_ = Nack::kNone;
  nack_seq_ = 0;
  planned_ = motion_.position();
  return true;
}

/// Axes stop, the ring is emptied; the numbers stay, so that the host sees what was not completed. Nothing
/// may follow in this session: what was dropped would count as completed.
void ModbusController::forget_blocks() {
  spent_ = true;
  motion_.stop();
  seqs_.clear();
  end_seq_.reset();
  done_ = false;
  planned_ = motion_.position();
}

/// As after power-on, but for the positions and the acknowledgement of the command itself.
void ModbusController::reset() {
  const bool moving = motion_.running() != nullptr && !motion_.held();
  forget_blocks();
  motion_.set_feed_override(100);
  alarm_ = moving ? kResetInMotion : 0;
  session_ = last_accepted_ = last_started_ = last_completed_ = 0;
  nack_ = Nack::kNone;
  nack_seq_ = heartbeat_ = 0;
  heartbeat_seen_ = false;
  ++boot_id_;
}

void ModbusController::take_heartbeat(std::uint16_t value) {
  if (!heartbeat_seen_ || value != heartbeat_) heartbeat_at_ = link_now_;
  heartbeat_seen_ = true;
  heartbeat_ = value;
}

std::optional<double> ModbusController::watchdog_at() const {
  if (session_ == 0 || !heartbeat_seen_) return std::nullopt;
  return heartbeat_at_ + options_.watchdog;
}

void ModbusController::advance_link(double link_now) {
  assert(link_now >= link_now_);
  link_now_ = link_now;
  const std::optional<double> deadline = watchdog_at();
  if (deadline && *deadline <= link_now_ && !motion_.idle()) motion_.hold();
}

}  // namespace tiltfeed::sim
