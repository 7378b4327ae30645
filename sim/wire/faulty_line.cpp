#include "sim/wire/faulty_line.h"

#include <algorithm>

namespace tiltfeed::sim {
namespace {

constexpr char kXoff = 0x13, kXon = 0x11;

bool names(Side rule, Side side) { return rule == Side::kBoth || rule == side; }
bool is_byte_fault(FaultKind kind) { return kind <= FaultKind::kDelay; }

}  // namespace

FaultyLine::FaultyLine(const FaultScript& script)
    : script_(script), random_(script.seed), done_(script.rules.size(), false) {
  for (const FaultRule& rule : script_.rules) {
    slow_read_ = slow_read_ || rule.kind == FaultKind::kSlowRead;
    if (!is_byte_fault(rule.kind)) continue;
    if (names(rule.side, Side::kToMachine)) machine_.probability += rule.probability;
    if (names(rule.side, Side::kToHost)) host_.probability += rule.probability;
  }
  machine_.clean = clean_run(Side::kToMachine);
  host_.clean = clean_run(Side::kToHost);
}

bool FaultyLine::chance(double probability) {
  return probability > 0.0 && std::uniform_real_distribution<double>(0.0, 1.0)(random_) < probability;
}

void FaultyLine::note(FaultKind kind) {
  ++faults_;
  ++counts_[static_cast<std::size_t>(kind)];
}

const FaultRule* FaultyLine::rule(FaultKind kind) const {
  for (const FaultRule& rule : script_.rules)
    if (rule.kind == kind) return &rule;
  return nullptr;
}

/// A rule with a time, once that time has come; or by chance at each question.
bool FaultyLine::due(FaultKind kind, double now) {
  for (std::size_t i = 0; i < script_.rules.size(); ++i) {
    const FaultRule& rule = script_.rules[i];
    if (rule.kind != kind || done_[i]) continue;
    if (rule.at >= 0.0 ? now < rule.at : !chance(rule.probability)) continue;
    if (rule.at >= 0.0) done_[i] = true;
    note(kind);
    return true;
  }
  return false;
}

bool FaultyLine::happens(FaultKind kind, Side side) {
  for (const FaultRule& rule : script_.rules)
    if (rule.kind == kind && names(rule.side, side) && chance(rule.probability)) return note(kind), true;
  return false;
}

bool FaultyLine::away(double now) {
  if (now >= away_until_ && due(FaultKind::kDisconnect, now)) {
    away_until_ = now + rule(FaultKind::kDisconnect)->seconds;
    for (Way* way : {&machine_, &host_}) {  // what was on the way is gone
      way->queue.clear();
      way->line.clear();
    }
  }
  return now < away_until_;
}

bool FaultyLine::silent(double now) {
  if (now >= silent_until_ && due(FaultKind::kSilence, now))
    silent_until_ = now + rule(FaultKind::kSilence)->seconds;
  return now < silent_until_;
}

/// How many bytes pass before the next one that is faulty.
std::uint64_t FaultyLine::clean_run(Side side) {
  const double p = (side == Side::kToMachine ? machine_ : host_).probability;
  if (p <= 0.0) return ~0ULL;
  return std::geometric_distribution<std::uint64_t>(std::min(p, 1.0))(random_);
}

/// What happens to a byte that is faulty, in proportion to the rules.
FaultKind FaultyLine::byte_fault(Side side) {
  const double p = (side == Side::kToMachine ? machine_ : host_).probability;
  double left = std::uniform_real_distribution<double>(0.0, p)(random_);
  FaultKind kind = FaultKind::kCorrupt;
  for (const FaultRule& rule : script_.rules) {
    if (!is_byte_fault(rule.kind) || !names(rule.side, side)) continue;
    kind = rule.kind;
    if ((left -= rule.probability) <= 0.0) break;
  }
  note(kind);
  return kind;
}

/// Byte faults. The way keeps its order: a delayed byte delays what follows.
void FaultyLine::spoil(std::string_view bytes, Side side, double now, Way& way) {
  const double at = std::max(now, way.not_before);
  if (way.queue.empty() || way.queue.back().at != at) way.queue.push_back({at, {}});
  while (!bytes.empty()) {
    std::string* out = &way.queue.back().bytes;
    if (way.clean >= bytes.size()) {
      way.clean -= bytes.size();
      *out += bytes;
      return;
    }
    *out += bytes.substr(0, way.clean);
    const char byte = bytes[way.clean];
    bytes.remove_prefix(way.clean + 1);
    switch (byte_fault(side)) {
      case FaultKind::kDrop:
        break;
      case FaultKind::kInsert:
        *out += {static_cast<char>(random_()), byte};
        break;
      case FaultKind::kDuplicate:
        *out += {byte, byte};
        break;
      case FaultKind::kDelay:
        way.not_before = std::max(way.not_before, now) + rule(FaultKind::kDelay)->seconds;
        way.queue.push_back({way.not_before, std::string(1, byte)});
        break;
      default:
        *out += static_cast<char>(byte ^ static_cast<char>(1 + random_() % 255));
    }
    way.clean = clean_run(side);
  }
}

void FaultyLine::to_machine(std::string_view bytes, double now) {
  if (away(now) || silent(now)) return;
  spoil(bytes, Side::kToMachine, now, machine_);
}

void FaultyLine::spoil_reply(std::string_view line, double now) {
  const bool ok = line.starts_with("ok");
  if (ok && happens(FaultKind::kLoseOk, Side::kToHost)) return;
  std::string text(line);
  const bool resend = line.starts_with("Resend:") || line.starts_with("rs");
  if (resend && happens(FaultKind::kWrongLine, Side::kToHost)) {
    // Another number of about the same length, as noise on a digit makes it.
    const std::size_t digit = text.find_first_of("0123456789");
    if (digit != text.npos) text[digit] = static_cast<char>('0' + (text[digit] - '0' + 3) % 10);
  }
  if (ok && due(FaultKind::kXoffStuck, now)) {
    spoil(std::string(1, kXoff), Side::kToHost, now, host_);
    host_.not_before = now + rule(FaultKind::kXoffStuck)->seconds;
    text = kXon + text;
  }
  spoil(text, Side::kToHost, now, host_);
  if (ok && happens(FaultKind::kExtraOk, Side::kToHost)) spoil(line, Side::kToHost, now, host_);
  if (resend && happens(FaultKind::kResendStorm, Side::kToHost))
    for (int i = 0; i < rule(FaultKind::kResendStorm)->value; ++i) spoil(line, Side::kToHost, now, host_);
}

void FaultyLine::to_host(std::string_view bytes, double now) {
  if (away(now) || silent(now)) return;
  for (const char byte : bytes) {
    host_.line += byte;
    if (byte != '\n') continue;
    spoil_reply(host_.line, now);
    host_.line.clear();
  }
  // Single control bytes (XON, XOFF) are no lines.
  if (!host_.line.empty() && static_cast<unsigned char>(host_.line.front()) < ' ' && host_.line[0] != '\r') {
    spoil(host_.line, Side::kToHost, now, host_);
    host_.line.clear();
  }
}

void FaultyLine::frame_to_host(std::string_view bytes, double now) {
  if (away(now) || silent(now)) return;
  spoil(bytes, Side::kToHost, now, host_);
}

std::string FaultyLine::take(Way& way, double now) {
  std::string bytes;
  while (!way.queue.empty() && way.queue.front().at <= now) {
    bytes += way.queue.front().bytes;
    way.queue.pop_front();
  }
  return bytes;
}

std::string FaultyLine::at_machine(double now) { return take(machine_, now); }
std::string FaultyLine::at_host(double now) { return take(host_, now); }

FrameFate FaultyLine::frame() {
  FrameFate fate;
  if (happens(FaultKind::kException, Side::kToHost)) fate.exception = rule(FaultKind::kException)->value;
  fate.lose_request = happens(FaultKind::kLoseRequest, Side::kToMachine);
  fate.lose_reply = happens(FaultKind::kLoseReply, Side::kToHost);
  fate.wrong_unit = happens(FaultKind::kWrongUnit, Side::kToHost);
  fate.half_frame = happens(FaultKind::kHalfFrame, Side::kToHost);
  if (happens(FaultKind::kLateReply, Side::kToHost)) fate.late = rule(FaultKind::kLateReply)->seconds;
  return fate;
}

}  // namespace tiltfeed::sim
