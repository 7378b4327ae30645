#pragma once
// A Modbus RTU line in made-up time, written from the standard: frames with CRC-16, a master that waits, is
// silent and flushes, and the simulated ring controller as slave; a fault script spoils what passes. Seeded
// bugs stand where a wrong program would have them, so that the campaign can show that it would see them.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/wire/link.h"
#include "daemon/wire/modbus_map.h"
#include "sim/controller/modbus_controller.h"
#include "sim/wire/faulty_line.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

enum class SeededBug {
  kNone,
  kNoDedup,           // the controller appends a repeated frame again
  kNoCrc,             // the controller checks neither CRC-16 nor CRC-32
  kEarlyAck,          // the controller acknowledges before it has looked at the frame
  kFullRingAck,       // the controller offers room that it has not, and acknowledges what it did not take
  kNoWrap,            // the controller compares sequence numbers as plain numbers
  kBlindMaster,       // the host takes any reply for true, whatever its CRC-16
  kSendIsDone,        // the host takes a frame for accepted when no reply comes
  kFreshNumbers,      // the host numbers a repeated frame anew
  kBootIgnored,       // the host goes on after a restart of the controller
  kUnitIgnored,       // the host takes the reply of another unit
  kNoHeartbeat,       // the host forgets the heartbeat
  kResumeFromRecord,  // the host goes on where its record ends, not where the controller says
  kResumeAsNewRun,    // the host opens another session for the rest
  kLast = kResumeAsNewRun
};

inline std::uint16_t crc16(const std::string& bytes, std::size_t count) {
  static const auto kTable = [] {
    std::array<std::uint16_t, 256> table{};
    for (unsigned i = 0; i < 256; ++i) {
      unsigned crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xA001u : crc >> 1;
      table[i] = static_cast<std::uint16_t>(crc);
    }
    return table;
  }();
  std::uint16_t crc = 0xFFFF;
  for (std::size_t i = 0; i < count; ++i)
    crc = static_cast<std::uint16_t>(crc >> 8 ^ kTable[(crc ^ static_cast<unsigned char>(bytes[i])) & 0xFF]);
  return crc;
}

class RingWire : public Link, public Clock {
 public:
  RingWire(const MachineModel& machine, sim::FaultScript script, sim::ModbusOptions options, SeededBug bug,
           sim::Motion::Sink sink)
      : controller(machine, {}, options, std::move(sink)), line(script), bug_(bug) {}

  Time now() override { return std::chrono::duration_cast<Time>(std::chrono::duration<double>(time_)); }

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (++exchanges >= die_at) return fail(Code::kLink, "killed");
    if (exchanges > most_exchanges) return fail(Code::kLink, "stuck");
    if (out.empty()) {
      pass(std::chrono::duration<double>(wait).count());
      return 0;
    }
    in += pack_reply(ask(unpack_request(out)));
    return out.size();
  }

  /// What an operator does at the controller's panel.
  void clear_alarm() {
    controller.write(sim::kMailboxAt,
                     encode_mailbox(status_word(2), static_cast<std::uint16_t>(status_word(11) + 1),
                                    MailboxCode::kClearAlarm, 0, false));
  }

  sim::ModbusController controller;
  sim::FaultyLine line;
  std::uint64_t exchanges = 0, die_at = ~0ULL, most_exchanges = 100'000;
  std::uint64_t resets = 0;

 private:
  static constexpr double kByteTime = 11.0 / 115200, kTimeout = 0.15;
  static constexpr std::uint8_t kUnit = 1;

  void pass(double span) {
    time_ += span;
    controller.advance_link(time_);
    controller.advance(time_);
  }

  static void word(std::string& bytes, std::uint16_t value) {
    bytes += static_cast<char>(value >> 8);
    bytes += static_cast<char>(value & 0xFF);
  }
  static std::uint16_t word_at(const std::string& bytes, std::size_t at) {
    return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[at]) << 8 |
                                      static_cast<unsigned char>(bytes[at + 1]));
  }
  static void seal(std::string& frame) {
    const std::uint16_t crc = crc16(frame, frame.size());
    frame += static_cast<char>(crc & 0xFF);
    frame += static_cast<char>(crc >> 8);
  }
  static bool sealed(const std::string& frame) {
    if (frame.size() < 4) return false;
    const std::uint16_t crc = crc16(frame, frame.size() - 2);
    return static_cast<unsigned char>(frame[frame.size() - 2]) == (crc & 0xFF) &&
           static_cast<unsigned char>(frame[frame.size() - 1]) == crc >> 8;
  }

  // ---- master -------------------------------------------------------------------------------------------

  static std::string frame_of(const ModbusRequest& r) {
    std::string frame(1, static_cast<char>(kUnit));
    const auto writes = static_cast<std::uint16_t>(r.words.size());
    frame += static_cast<char>(writes == 0 ? 3 : r.read_count > 0 ? 23 : 16);
    if (r.read_count > 0) word(frame, r.read_address), word(frame, r.read_count);
    if (writes > 0) {
      word(frame, r.write_address), word(frame, writes);
      frame += static_cast<char>(2 * writes);
      for (const std::uint16_t one : r.words) word(frame, one);
    }
    seal(frame);
    return frame;
  }

  ModbusReply ask(ModbusRequest request) {
    if (bug_ == SeededBug::kNoHeartbeat && request.words.size() == 1) request.words.front() = 1;
    if (bug_ == SeededBug::kFreshNumbers) number_anew(request);
    const std::string frame = frame_of(request);
    pass(static_cast<double>(frame.size()) * kByteTime);
    line.to_machine(frame, time_);
    slave(line.at_machine(time_));
    static_cast<void>(line.at_machine(time_ + 1e9));  // what is delayed within a frame is no part of it
    return listen(request);
  }

  ModbusReply listen(const ModbusRequest& request) {
    const std::size_t expected = request.read_count > 0 ? 5u + 2u * request.read_count : 8u;
    const double deadline = time_ + kTimeout;
    std::string got;
    while (got.size() < expected && time_ < deadline) {
      pass(kTimeout / 16);
      got += line.at_host(time_);
      if (got.size() >= 5 && (got[1] & 0x80) != 0) break;
    }
    ModbusReply reply;
    const bool exception = got.size() >= 5 && (got[1] & 0x80) != 0 && got[2] >= 1 && got[2] <= 11;
    if (exception && sealed(got.substr(0, 5)) && got[0] == static_cast<char>(kUnit))
      return reply.outcome = static_cast<std::uint8_t>(got[2]), reply;
    const std::string frame = got.substr(0, expected);
    const bool fits = frame.size() == expected && (frame[0] == kUnit || bug_ == SeededBug::kUnitIgnored) &&
                      (sealed(frame) || bug_ == SeededBug::kBlindMaster);
    if (fits) {
      reply.outcome = kReplyOk;
      for (std::size_t i = 0; i < request.read_count; ++i) reply.words.push_back(word_at(frame, 3 + 2 * i));
      return tamper(reply);
    }
    pass(kTimeout);  // a late reply comes now, or spoils the next exchange
    static_cast<void>(line.at_host(time_));
    if (bug_ == SeededBug::kSendIsDone && !request.words.empty() && request.words.size() > 7)
      return claim(request);
    return reply;
  }

  ModbusReply tamper(ModbusReply reply) {
    if (reply.words.size() == 24) last_status_ = reply.words;
    return reply;
  }

  /// The reply that a host imagines which takes sending for done.
  ModbusReply claim(const ModbusRequest& request) {
    ModbusReply reply;
    if (last_status_.empty()) return reply;
    reply.outcome = kReplyOk;
    reply.words = last_status_;
    reply.words[3] = static_cast<std::uint16_t>(request.words[1] + request.words[2] - 1);
    reply.words[0] = reply.words[23] = static_cast<std::uint16_t>(reply.words[0] + 0x4000);
    return reply;
  }

  void number_anew(ModbusRequest& request) {
    if (request.words.size() != 118) return;
    const bool repeated = request.words == last_window_;
    last_window_ = request.words;
    if (repeated) shift_ = static_cast<std::uint16_t>(shift_ + request.words[2]);
    renumber(request.words, shift_);
  }

  static void renumber(std::vector<std::uint16_t>& words, std::uint16_t by) {
    words[1] = static_cast<std::uint16_t>(words[1] + by);
    for (std::size_t k = 0; k < words[2] && k < 7; ++k)
      words[6 + 16 * k] = static_cast<std::uint16_t>(words[6 + 16 * k] + by);
    reseal(words);
  }
  static void reseal(std::vector<std::uint16_t>& words) {
    std::vector<std::uint16_t> guarded(words);
    guarded.erase(guarded.begin() + 4, guarded.begin() + 6);
    const std::uint32_t crc = sim::crc_of_words(guarded);
    words[4] = static_cast<std::uint16_t>(crc >> 16);
    words[5] = static_cast<std::uint16_t>(crc);
  }

  // ---- slave --------------------------------------------------------------------------------------------

  void slave(std::string frame) {
    if (line.reset_due(time_)) {
      ++resets;
      const auto mail = encode_mailbox(status_word(2), static_cast<std::uint16_t>(status_word(11) + 1),
                                       MailboxCode::kReset, 0, false);
      controller.write(sim::kMailboxAt, mail);
    }
    const sim::FrameFate fate = line.frame();
    if (fate.lose_request || frame.size() < 8 || frame[0] != kUnit) return;
    const int code = frame[1];
    const bool whole = sealed(frame);
    early_ack_.reset();
    if (!whole && bug_ == SeededBug::kEarlyAck && code == 23 && frame.size() == 249)
      early_ack_ = static_cast<std::uint16_t>(word_at(frame, 13) + word_at(frame, 15) - 1);
    if (!whole && bug_ != SeededBug::kNoCrc && !early_ack_) return;
    if (fate.exception != 0)
      return answer(
          {static_cast<char>(kUnit), static_cast<char>(code | 0x80), static_cast<char>(fate.exception)},
          fate);
    std::string reply(1, static_cast<char>(kUnit));
    reply += frame[1];
    const std::size_t write_at = code == 16 ? 2 : 6;
    if (code == 16 || code == 23) {
      const std::uint16_t count = word_at(frame, write_at + 2 > frame.size() - 2 ? 2 : write_at + 2);
      if (frame.size() < write_at + 7 + 2u * count) return;
      std::vector<std::uint16_t> words;
      for (std::size_t i = 0; i < count; ++i) words.push_back(word_at(frame, write_at + 5 + 2 * i));
      if (!early_ack_) store(word_at(frame, write_at), words);
      if (code == 16) reply += frame.substr(2, 4);
    }
    if (code == 3 || code == 23) {
      const std::uint16_t count = word_at(frame, 4);
      if (count > 125) return;
      std::vector<std::uint16_t> words(count);
      if (controller.read(word_at(frame, 2), words) != sim::Access::kOk) return;
      if (early_ack_ && count == 24) words[3] = *early_ack_;
      if (bug_ == SeededBug::kFullRingAck && count == 24) words[6] = std::max<std::uint16_t>(words[6], 7);
      if (fate.wrong_unit && count == 24)
        words[3] = static_cast<std::uint16_t>(words[3] + 3);  // another machine's
      reply += static_cast<char>(2 * count);
      for (const std::uint16_t one : words) word(reply, one);
    }
    answer(std::move(reply), fate);
  }

  void answer(std::string reply, const sim::FrameFate& fate) {
    if (fate.lose_reply) return;
    if (fate.wrong_unit) reply[0] = 9;
    seal(reply);
    if (fate.half_frame) reply.resize(reply.size() / 2);
    line.frame_to_host(reply, time_ + fate.late);
  }

  std::uint16_t status_word(std::size_t at) {
    std::vector<std::uint16_t> words(24);
    controller.read(sim::kStatusAt, words);
    return words[at];
  }

  void store(std::uint16_t address, std::vector<std::uint16_t> words) {
    if (address != sim::kWindowAt || words.size() != 118) return void(controller.write(address, words));
    const std::uint16_t before = status_word(3);
    const auto last = static_cast<std::uint16_t>(words[1] + words[2] - 1);
    if (bug_ == SeededBug::kNoCrc) reseal(words);
    if (bug_ == SeededBug::kNoDedup && static_cast<std::int16_t>(words[1] - before) <= 0)
      renumber(words, static_cast<std::uint16_t>(before + 1 - words[1]));
    if (bug_ == SeededBug::kNoWrap && last < before) return;
    controller.write(address, words);
    if (bug_ == SeededBug::kFullRingAck && status_word(3) != last && status_word(6) == 0) early_ack_ = last;
  }

  SeededBug bug_;
  double time_ = 0.0;
  std::vector<std::uint16_t> last_status_, last_window_;
  std::optional<std::uint16_t> early_ack_;
  std::uint16_t shift_ = 0;
};

}  // namespace tiltfeed
