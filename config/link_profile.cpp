#include "config/link_profile.h"

#include "config/description.h"
#include "config/enum_words.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {

namespace {

constexpr Words<Parity> kParityWords = {
    {"none", Parity::kNone}, {"even", Parity::kEven}, {"odd", Parity::kOdd}};
constexpr Words<FlowControl> kFlowWords = {
    {"none", FlowControl::kNone}, {"xon_xoff", FlowControl::kXonXoff}, {"rts_cts", FlowControl::kRtsCts}};
constexpr Words<EndOfBlock> kEndWords = {{"lf", EndOfBlock::kLf},
                                         {"crlf", EndOfBlock::kCrLf},
                                         {"cr", EndOfBlock::kCr},
                                         {"lf_cr_cr", EndOfBlock::kLfCrCr}};
constexpr Words<ToolChanges> kChangeWords = {{"guided", ToolChanges::kGuided},
                                             {"control", ToolChanges::kControl}};
constexpr int kMostLeader = 10000;

RingMap read_ring(const Section& wire) {
  const Section ring =
      wire.optional_section("ring", {"identity", "window", "mailbox", "status", "positions", "heartbeat",
                                     "low_word_first", "linear_exponent", "rotary_exponent", "watchdog_s"});
  RingMap map;
  const auto address = [&](const char* key, std::uint16_t usual) {
    return static_cast<std::uint16_t>(ring.integer(key, 0, kHighestAddress, usual));
  };
  map.identity = address("identity", map.identity);
  map.window = address("window", map.window);
  map.mailbox = address("mailbox", map.mailbox);
  map.status = address("status", map.status);
  map.positions = address("positions", map.positions);
  map.heartbeat = address("heartbeat", map.heartbeat);
  map.low_word_first = ring.flag("low_word_first", map.low_word_first);
  map.linear_exponent = ring.integer("linear_exponent", -1, 6, map.linear_exponent);
  map.rotary_exponent = ring.integer("rotary_exponent", -1, 6, map.rotary_exponent);
  map.watchdog = ring.number("watchdog_s", {0.1, 60.0}, map.watchdog);
  return map;
}

DripFormat read_drip(const Section& wire) {
  const Section drip = wire.optional_section(
      "dnc", {"data_bits", "parity", "stop_bits", "flow", "end_of_block", "leader_bytes", "trailer_bytes",
              "percent", "wait_for_start", "xon", "xoff"});
  DripFormat format;
  format.data_bits = drip.integer("data_bits", 7, 8, format.data_bits);
  format.parity = drip.choice<Parity>("parity", kParityWords, format.parity);
  format.stop_bits = drip.integer("stop_bits", 1, 2, format.stop_bits);
  format.flow = drip.choice<FlowControl>("flow", kFlowWords, format.flow);
  format.end_of_block = drip.choice<EndOfBlock>("end_of_block", kEndWords, format.end_of_block);
  format.leader = drip.integer("leader_bytes", 0, kMostLeader, format.leader);
  format.trailer = drip.integer("trailer_bytes", 0, kMostLeader, format.trailer);
  format.percent = drip.flag("percent", format.percent);
  format.wait_for_start = drip.flag("wait_for_start", format.wait_for_start);
  format.xon = static_cast<char>(drip.integer("xon", 1, 31, format.xon));
  format.xoff = static_cast<char>(drip.integer("xoff", 1, 31, format.xoff));
  if (format.xon == format.xoff)
    drip.complain("xoff", "is the same byte as xon; expected two different ones");
  return format;
}

}  // namespace

LinkProfile read_link_profile(const Section& root) {
  const Section wire = root.optional_section(
      "wire", {"line_numbers", "check", "position_tolerance_mm", "position_tolerance_deg", "reprap_window",
               "tool_changes", "tool_length_tolerance_mm", "dnc", "ring", "drive"});
  LinkProfile profile;
  profile.line_numbers = wire.flag("line_numbers", profile.line_numbers);
  profile.check = wire.flag("check", profile.check);
  profile.position.mm = wire.number("position_tolerance_mm", {0.001, 1000.0}, profile.position.mm);
  profile.position.deg = wire.number("position_tolerance_deg", {0.001, 1000.0}, profile.position.deg);
  profile.reprap_window = wire.integer("reprap_window", 0, 64, profile.reprap_window);
  profile.tool_changes = wire.choice<ToolChanges>("tool_changes", kChangeWords, profile.tool_changes);
  profile.tool_length_tolerance =
      wire.number("tool_length_tolerance_mm", {0.0001, 1000.0}, profile.tool_length_tolerance);
  profile.drip = read_drip(wire);
  profile.ring = read_ring(wire);
  profile.drive = read_drive(wire);
  return profile;
}

void describe(const LinkProfile& profile, Description& out) {
  const DripFormat& drip = profile.drip;
  const RingMap& ring = profile.ring;
  out.add("wire.line_numbers", profile.line_numbers);
  out.add("wire.check", profile.check);
  out.add("wire.position_tolerance_mm", profile.position.mm);
  out.add("wire.position_tolerance_deg", profile.position.deg);
  out.add("wire.reprap_window", profile.reprap_window);
  out.add("wire.tool_changes", word(kChangeWords, profile.tool_changes));
  out.add("wire.tool_length_tolerance_mm", profile.tool_length_tolerance);
  out.add("wire.dnc.data_bits", drip.data_bits);
  out.add("wire.dnc.parity", word(kParityWords, drip.parity));
  out.add("wire.dnc.stop_bits", drip.stop_bits);
  out.add("wire.dnc.flow", word(kFlowWords, drip.flow));
  out.add("wire.dnc.end_of_block", word(kEndWords, drip.end_of_block));
  out.add("wire.dnc.leader_bytes", drip.leader);
  out.add("wire.dnc.trailer_bytes", drip.trailer);
  out.add("wire.dnc.percent", drip.percent);
  out.add("wire.dnc.wait_for_start", drip.wait_for_start);
  out.add("wire.dnc.xon", static_cast<int>(drip.xon));
  out.add("wire.dnc.xoff", static_cast<int>(drip.xoff));
  out.add("wire.ring.identity", static_cast<int>(ring.identity));
  out.add("wire.ring.window", static_cast<int>(ring.window));
  out.add("wire.ring.mailbox", static_cast<int>(ring.mailbox));
  out.add("wire.ring.status", static_cast<int>(ring.status));
  out.add("wire.ring.positions", static_cast<int>(ring.positions));
  out.add("wire.ring.heartbeat", static_cast<int>(ring.heartbeat));
  out.add("wire.ring.low_word_first", ring.low_word_first);
  out.add("wire.ring.linear_exponent", ring.linear_exponent);
  out.add("wire.ring.rotary_exponent", ring.rotary_exponent);
  out.add("wire.ring.watchdog_s", ring.watchdog);
  describe(profile.drive, out);
}

}  // namespace tiltfeed::config
