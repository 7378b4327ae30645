// What agents are told: names held against the standard's, lines against its rules, two agents on one
// adapter.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "config/machine_profile.h"
#include "daemon/mtconnect/adapter.h"
#include "daemon/mtconnect/service_watch.h"

namespace tiltfeed {
using namespace daemon;
namespace {

MachineModel machine(const std::string& name) {
  const auto profile = config::load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile->model;
}

std::map<std::string, std::string> fields(const std::string& line) {
  std::map<std::string, std::string> out;
  std::istringstream in(line);
  std::string time, key, value;
  std::getline(in, time, '|');
  while (std::getline(in, key, '|') && std::getline(in, value, '|')) out[key] = value;
  return out;
}

/// MTConnect 2.2, part 2: category, sub types and units of the types that are used.
struct Published {
  const char* category;
  std::set<std::string> sub_types, units;
};
const std::map<std::string, Published> kPublished = {
    {"AVAILABILITY", {"EVENT", {""}, {""}}},
    {"CONTROLLER_MODE", {"EVENT", {""}, {""}}},
    {"EXECUTION", {"EVENT", {""}, {""}}},
    {"PROGRAM", {"EVENT", {"", "SCHEDULE", "MAIN", "ACTIVE"}, {""}}},
    {"LINE_NUMBER", {"EVENT", {"ABSOLUTE", "INCREMENTAL"}, {""}}},
    {"BLOCK", {"EVENT", {""}, {""}}},
    {"PART_COUNT", {"EVENT", {"", "ALL", "GOOD", "BAD", "TARGET", "REMAINING"}, {""}}},
    {"PATH_FEEDRATE_OVERRIDE", {"EVENT", {"JOG", "PROGRAMMED", "RAPID"}, {""}}},
    {"ROTARY_VELOCITY_OVERRIDE", {"EVENT", {""}, {""}}},
    {"ROTARY_MODE", {"EVENT", {""}, {""}}},
    {"PATH_FEEDRATE",
     {"SAMPLE", {"ACTUAL", "COMMANDED", "JOG", "PROGRAMMED", "RAPID"}, {"MILLIMETER/SECOND"}}},
    {"ROTARY_VELOCITY", {"SAMPLE", {"ACTUAL", "COMMANDED", "PROGRAMMED"}, {"REVOLUTION/MINUTE"}}},
    {"PATH_POSITION", {"SAMPLE", {"ACTUAL", "COMMANDED", "TARGET", "PROBE"}, {"MILLIMETER_3D"}}},
    {"POSITION", {"SAMPLE", {"ACTUAL", "COMMANDED", "PROGRAMMED", "TARGET"}, {"MILLIMETER"}}},
    {"ANGLE", {"SAMPLE", {"ACTUAL", "COMMANDED"}, {"DEGREE"}}},
    {"COMMUNICATIONS", {"CONDITION", {""}, {""}}},
    {"LOGIC_PROGRAM", {"CONDITION", {""}, {""}}},
    {"MOTION_PROGRAM", {"CONDITION", {""}, {""}}},
    {"SYSTEM", {"CONDITION", {""}, {""}}},
};

TEST(Mtconnect, ItemsAreThoseOfTheStandard) {
  const char* const names[] = {"SAMPLE", "EVENT", "CONDITION"};
  for (const char* const profile : {"generic-ac", "mill-3x", "mill-4x-table-a", "linuxcnc-bridge-bc"}) {
    std::set<std::string> ids;
    for (const DataItem& item : data_items(machine(profile))) {
      ASSERT_TRUE(kPublished.contains(item.type)) << item.type;
      const Published& published = kPublished.at(item.type);
      EXPECT_EQ(names[static_cast<int>(item.category)], std::string(published.category)) << item.type;
      EXPECT_TRUE(published.sub_types.contains(item.sub_type)) << item.type << " " << item.sub_type;
      EXPECT_TRUE(published.units.contains(item.units)) << item.type << " " << item.units;
      EXPECT_TRUE(ids.insert(item.id).second) << item.id << " comes twice";
    }
  }
}

TEST(Mtconnect, TheDeviceFileDeclaresEachItemOnceAndOnlyAxesThatAreThere) {
  const std::map<std::string, std::set<std::string>> axes = {
      {"generic-ac", {"X", "Y", "Z", "A", "C", "S"}},
      {"linuxcnc-bridge-bc", {"X", "Y", "Z", "B", "C", "S"}},
      {"mill-4x-table-a", {"X", "Y", "Z", "A", "S"}},
      {"mill-3x", {"X", "Y", "Z", "S"}}};
  for (const auto& [profile, expected] : axes) {
    const std::string xml = device_file(machine(profile), "");
    std::set<std::string> found, ids;
    const std::regex axis("<(Linear|Rotary) id=\"[^\"]+\" name=\"(.)\""),
        item("<DataItem [^>]*\\bname=\"([A-Za-z_]+)\"[^>]*/>");
    for (std::sregex_iterator at(xml.begin(), xml.end(), axis), end; at != end; ++at) found.insert((*at)[2]);
    EXPECT_EQ(found, expected) << profile;
    for (std::sregex_iterator at(xml.begin(), xml.end(), item), end; at != end; ++at)
      EXPECT_TRUE(ids.insert((*at)[1]).second) << (*at)[1];
    for (const DataItem& one : data_items(machine(profile))) EXPECT_EQ(ids.count(one.id), 1u) << one.id;
    EXPECT_EQ(ids.size(), data_items(machine(profile)).size());
  }
}

/// xs:ID: once in a document, and an agent has one for all of its devices.
TEST(Mtconnect, MachinesOfOneProfileHaveNoIdInCommon) {
  std::set<std::string> ids, uuids;
  std::size_t count = 0;
  for (const char* const service : {"north", "south 2", "5axis", ""}) {
    const std::string xml = device_file(machine("generic-ac"), service);
    const std::regex id(" id=\"([A-Za-z][A-Za-z0-9_.-]*)\""), uuid(" uuid=\"([^\"]+)\""), any(" id=\"");
    std::sregex_iterator end;
    for (std::sregex_iterator at(xml.begin(), xml.end(), id); at != end; ++at, ++count) ids.insert((*at)[1]);
    std::smatch found;
    ASSERT_TRUE(std::regex_search(xml, found, uuid));
    uuids.insert(found[1]);
    EXPECT_EQ(std::distance(std::sregex_iterator(xml.begin(), xml.end(), any), end),
              std::distance(std::sregex_iterator(xml.begin(), xml.end(), id), end))
        << service;
  }
  EXPECT_EQ(ids.size(), count);
  EXPECT_EQ(uuids.size(), 4u);
}

TEST(Mtconnect, AServiceThatDoesNotAnswerIsUnavailableInEveryItem) {
  const auto items = data_items(machine("generic-ac"));
  const auto said = observe(items, std::nullopt);
  ASSERT_TRUE(said);
  for (const DataItem& item : items)
    EXPECT_TRUE(said->at(item.id).starts_with("UNAVAILABLE")) << item.id << " " << said->at(item.id);
}

TEST(Mtconnect, ARunIsToldInTheStandardsWordsAndUnits) {
  const auto items = data_items(machine("generic-ac"));
  ServiceView view;
  view.job =
      R"({"job":3,"name":"a|b","state":"running","phase":"hold","machine":"Hold:0","held":"held on request",
    "program":{"X":1.5,"Y":-2,"Z":30,"A":-45,"C":370.25},"uncertain_lines":[17,25],"feed_mm_per_min":1200,"spindle_rpm":8000,"override":{"feed":90,"spindle":110}})";
  view.block = "G1 X1.5 F1200";
  view.parts = 4;
  const auto said = observe(items, view);
  ASSERT_TRUE(said) << said.error().message;
  const std::map<std::string, std::string> expected = {{"avail", "AVAILABLE"},
                                                       {"mode", "AUTOMATIC"},
                                                       {"execution", "FEED_HOLD"},
                                                       {"program", "\"a\\|b\""},
                                                       {"line", "17"},
                                                       {"block", "G1 X1.5 F1200"},
                                                       {"parts", "4"},
                                                       {"feed_override", "90"},
                                                       {"rapid_override", "UNAVAILABLE"},
                                                       {"position", "1.5 -2 30"},
                                                       {"X_position", "1.5"},
                                                       {"A_angle", "-45"},
                                                       {"C_angle", "370.25"},
                                                       {"rapid_override", "UNAVAILABLE"},
                                                       {"S_override", "110"},
                                                       {"feedrate", "20.0"},
                                                       {"S_speed", "8000"},
                                                       {"S_mode", "SPINDLE"},
                                                       {"motion", "WARNING|Hold:0|||held on request"},
                                                       {"comms", "NORMAL||||"}};
  for (const auto& [id, value] : expected) EXPECT_EQ(said->at(id), value) << id;
}

TEST(Mtconnect, EveryEndOfARunHasItsExecution) {
  const auto items = data_items(machine("generic-ac"));
  const std::map<std::string, std::string> expected = {
      {"done", "PROGRAM_COMPLETED"},  {"stopped", "STOPPED"},       {"failed", "STOPPED"},
      {"interrupted", "INTERRUPTED"}, {"uncertain", "INTERRUPTED"}, {"unknown", "READY"}};
  for (const auto& [outcome, execution] : expected) {
    ServiceView view;
    view.last = R"({"run":1,"outcome":")" + outcome + R"(","note":"line 12 may have run"})";
    const auto said = observe(items, view);
    ASSERT_TRUE(said);
    EXPECT_EQ(said->at("execution"), execution) << outcome;
    EXPECT_EQ(said->at("mode"), "UNAVAILABLE");
    const bool lost = execution == "INTERRUPTED";
    EXPECT_EQ(said->at("comms"), lost ? "FAULT|" + outcome + "|||line 12 may have run" : "NORMAL||||");
  }
  ServiceView broken;
  broken.job = "{";
  EXPECT_FALSE(observe(items, broken));
}

TEST(Mtconnect, OnlyWhatChangedIsToldAndConditionsHaveLinesOfTheirOwn) {
  const auto items = data_items(machine("generic-ac"));
  ServiceView view;
  const auto before = observe(items, view);
  const std::string all = shdr_lines(items, nullptr, *before, "T");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 1 + 4);
  const std::string first = all.substr(0, all.find('\n'));
  EXPECT_EQ(fields(first).size(), items.size() - 4);
  EXPECT_EQ(shdr_lines(items, &*before, *before, "T"), "");
  view.job = R"({"state":"running","phase":"alarm","machine":"Alarm:1","words":"a limit switch\nwas hit"})";
  const auto now = observe(items, view);
  EXPECT_EQ(
      shdr_lines(items, &*before, *now, "T"),
      "T|mode|AUTOMATIC|execution|INTERRUPTED|program|\nT|system|FAULT|Alarm:1|||a limit switch was hit\n");
}

/// An agent's end of the line.
class Agent {
 public:
  explicit Agent(const std::string& address) {
    fd_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    EXPECT_EQ(::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  }
  Agent(const Agent&) = delete;
  ~Agent() { ::close(fd_); }
  void say(const std::string& text) {
    EXPECT_EQ(::send(fd_, text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
  }
  /// What is there by now.
  std::string read(Adapter& adapter) {
    std::string out;
    for (int turn = 0; turn < 5; ++turn) {
      adapter.serve(std::chrono::milliseconds(10));
      char bytes[65536];
      for (ssize_t size; (size = ::recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT)) > 0;)
        out.append(bytes, static_cast<std::size_t>(size));
    }
    return out;
  }

 private:
  int fd_ = -1;
};

TEST(Mtconnect, AgentsComeAndGoAndEachHearsAllThenWhatChanges) {
  const auto items = data_items(machine("generic-ac"));
  auto adapter = Adapter::open("127.0.0.1:0", items, "1.2");
  ASSERT_TRUE(adapter) << adapter.error().message;
  adapter->tell(*observe(items, std::nullopt));
  Agent one(adapter->address());
  const std::string first = one.read(*adapter);
  EXPECT_NE(first.find("* adapterVersion: 1.2\n"), first.npos);
  EXPECT_TRUE(
      std::regex_search(first, std::regex("\n20..-..-..T..:..:..\\.[0-9]{3}Z\\|avail\\|UNAVAILABLE\\|")))
      << first;
  {
    Agent two(adapter->address());
    EXPECT_NE(two.read(*adapter).find("|avail|UNAVAILABLE|"), first.npos);
    EXPECT_EQ(adapter->agents(), 2u);
    adapter->tell(*observe(items, ServiceView{}));
    EXPECT_NE(two.read(*adapter).find("|avail|AVAILABLE|"), first.npos);
  }
  const std::string told = one.read(*adapter);
  EXPECT_NE(told.find("|avail|AVAILABLE|execution|READY|parts|0|"), told.npos) << told;
  EXPECT_EQ(told.find("program"), told.npos) << told;
  one.say("* PI");
  EXPECT_EQ(one.read(*adapter), "");
  one.say("NG\n* PING\n");
  EXPECT_EQ(one.read(*adapter), "* PONG 10000\n* PONG 10000\n");
  EXPECT_EQ(adapter->agents(), 1u);
  Agent late(adapter->address());
  EXPECT_NE(late.read(*adapter).find("|execution|READY|"), first.npos);
}

TEST(Mtconnect, AnAgentThatDoesNotReadOrTalksWithoutEndIsLetGo) {
  const auto items = data_items(machine("generic-ac"));
  auto adapter = Adapter::open("127.0.0.1:0", items, "1");
  ASSERT_TRUE(adapter);
  Agent deaf(adapter->address()), good(adapter->address()), chatter(adapter->address());
  good.read(*adapter);
  ASSERT_EQ(adapter->agents(), 3u);
  chatter.say(std::string(5000, 'x'));
  good.read(*adapter);
  EXPECT_EQ(adapter->agents(), 2u);
  ServiceView view;
  for (int turn = 0; adapter->agents() == 2 && turn < 1000; ++turn) {
    for (int i = 0; i < 200; ++i) {
      view.block = std::string(250, static_cast<char>('a' + i % 2));
      view.job = R"({"phase":"run"})";
      adapter->tell(*observe(items, view));
    }
    good.read(*adapter);
  }
  EXPECT_EQ(adapter->agents(), 1u);
  view.job = R"({"phase":"hold"})";
  adapter->tell(*observe(items, view));
  EXPECT_NE(good.read(*adapter).find("FEED_HOLD"), std::string::npos);
}

TEST(Mtconnect, AnAddressThatIsNoneOrIsTakenIsRefused) {
  for (const char* const wrong : {"", "7878", ":7878", "127.0.0.1:", "127.0.0.1:x", "no such host:1"})
    EXPECT_FALSE(Adapter::open(wrong, {}, "1")) << wrong;
  const auto first = Adapter::open("127.0.0.1:0", {}, "1");
  const auto second = Adapter::open(first->address(), {}, "1");
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find(first->address()), std::string::npos);
}

TEST(Mtconnect, TheLineInExecutionIsReadForwardsAndBackwards) {
  const std::string path = testing::TempDir() + "/mtconnect_program.nc";
  std::ofstream(path) << "G21\nG0 X1\nG1 X2";
  ProgramLine program;
  EXPECT_EQ(program.read(path, 2), "G0 X1");
  EXPECT_EQ(program.read(path, 2), "G0 X1");
  EXPECT_EQ(program.read(path, 3), "G1 X2");
  EXPECT_EQ(program.read(path, 1), "G21");
  EXPECT_EQ(program.read(path, 4), "");
  EXPECT_EQ(program.read(path, 3), "G1 X2");
  EXPECT_EQ(program.read(path, 0), "");
  EXPECT_EQ(program.read(path + "x", 1), "");
}

}  // namespace
}  // namespace tiltfeed
