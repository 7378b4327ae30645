// No message advises what the link in use does not have.

#include "daemon/machine/advice.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "daemon/machine/machine_orders.h"
#include "daemon/machine/stop_machine.h"

namespace tiltfeed {
using namespace daemon;
namespace {

namespace fs = std::filesystem;

constexpr LinkKind kKinds[] = {LinkKind::kGrbl,      LinkKind::kRepRap,    LinkKind::kDrip,
                               LinkKind::kModbusTcp, LinkKind::kModbusRtu, LinkKind::kDriveTcp,
                               LinkKind::kDriveRtu};

/// "reset", and commands of `tiltfeed machine` that are in the table, as a text names them.
std::vector<std::string> named_in(const std::string& text) {
  static const std::regex kNamed("tiltfeed (reset|machine ([a-z]+)( (park|measure))?)");
  std::vector<std::string> names;
  for (std::sregex_iterator at(text.begin(), text.end(), kNamed), end; at != end; ++at) {
    if ((*at)[1] == "reset")
      names.push_back("reset");
    else if (find_machine_order((*at)[2].str()) != nullptr)
      names.push_back((*at)[2].str() + (*at)[3].str());
  }
  return names;
}

/// A source's text, with its strings joined over the ends of lines.
std::string text_of(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return std::regex_replace(text.str(), std::regex("\"\\s*\n\\s*\""), "");
}

/// The kinds that a source is for, by its name; none: for all, so that it has to ask.
std::vector<LinkKind> kinds_of(const std::string& name) {
  const std::pair<const char*, std::vector<LinkKind>> kOf[] = {
      {"grbl_", {LinkKind::kGrbl}},
      {"order_motion", {LinkKind::kGrbl}},
      {"order_offsets", {LinkKind::kGrbl}},
      {"order_settings", {LinkKind::kGrbl}},
      {"order_parts", {LinkKind::kGrbl}},
      {"order_tool", {LinkKind::kGrbl}},
      {"reprap_", {LinkKind::kRepRap}},
      {"order_reprap", {LinkKind::kRepRap}},
      {"modbus_", {LinkKind::kModbusTcp, LinkKind::kModbusRtu}},
      {"ring_", {LinkKind::kModbusTcp, LinkKind::kModbusRtu}},
      {"order_ring", {LinkKind::kModbusTcp, LinkKind::kModbusRtu}},
      {"drive_", {LinkKind::kDriveTcp, LinkKind::kDriveRtu}},
      {"drip_", {LinkKind::kDrip}},
  };
  for (const auto& [begin, kinds] : kOf)
    if (name.starts_with(begin)) return kinds;
  return {};
}

config::ProgramFormat without_retract() {
  config::ProgramFormat format;
  format.retract = "none";
  return format;
}

TEST(Advice, EveryTextNamesWhatItsLinkHas) {
  for (const LinkKind kind : kKinds)
    for (const std::string& text : {tool_off_advice(kind, {}), tool_off_advice(kind, without_retract()),
                                    tool_by_hand_advice(kind), forget_advice(kind), way_free_advice(kind)})
      for (const std::string& name : named_in(text))
        EXPECT_TRUE(can_order(kind, name)) << static_cast<int>(kind) << ": " << text;
}

TEST(Advice, OnlyWhatAsksTheTableNamesACommandForAllLinks) {
  const std::string own[] = {"advice.cpp", "machine_orders.cpp"};
  int named = 0;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(SOURCE_DIR "/daemon")) {
    if (file.path().extension() != ".cpp") continue;
    const std::string name = file.path().filename().string();
    if (std::find(std::begin(own), std::end(own), name) != std::end(own)) continue;
    const std::vector<LinkKind> kinds = kinds_of(name);
    for (const std::string& order : named_in(text_of(file.path()))) {
      ++named;
      EXPECT_FALSE(kinds.empty()) << name << " names '" << order
                                  << "' for links that may not have it: use advice.h";
      for (const LinkKind kind : kinds) EXPECT_TRUE(can_order(kind, order)) << name << ": " << order;
    }
  }
  EXPECT_GT(named, 10) << "the sources were read";
}

TEST(Advice, WhatALinkHasIsWhatItPerforms) {
  EXPECT_EQ(orders_in_change(LinkKind::kGrbl), "status, tool park, tool measure, jog, probe and unlock");
  EXPECT_EQ(orders_in_change(LinkKind::kRepRap), "status, tool park, jog and unlock");
  EXPECT_EQ(orders_in_change(LinkKind::kModbusTcp), "status and unlock");
  EXPECT_EQ(orders_in_change(LinkKind::kDriveTcp), "status");
  EXPECT_EQ(orders_in_change(LinkKind::kDrip), "");
  EXPECT_NE(tool_off_advice(LinkKind::kModbusTcp, {}).find("`tiltfeed reset`"), std::string::npos);
  EXPECT_NE(tool_off_advice(LinkKind::kGrbl, {}).find("machine tool park"), std::string::npos);
  EXPECT_EQ(forget_advice(LinkKind::kDrip).find("tiltfeed reset"), std::string::npos);
}

/// `machine tool park` is the profile's retract line.
TEST(Advice, WithoutARetractLineTheToolIsJoggedOff) {
  const std::string text = tool_off_advice(LinkKind::kGrbl, without_retract());
  EXPECT_NE(text.find("`tiltfeed machine jog`"), std::string::npos) << text;
  EXPECT_EQ(text.find("tool park"), std::string::npos) << text;
}

}  // namespace
}  // namespace tiltfeed
