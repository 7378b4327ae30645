// One service a spool, one a machine: by whatever name the machine is called.

#include "daemon/service/state_lock.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>

#include "daemon/files/sha256.h"
#include "daemon/service/job_service.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

LinkSpec link_to(const std::string& text) { return *parse_link(text); }

ServiceConfig config_of(const std::string& spool, const std::string& link) {
  ServiceConfig config;
  config.machine.model = wide_machine();
  config.machine.model.name = "wide";
  config.spool = spool;
  config.link = link;
  return config;
}

/// Every file beneath, with its content's digest and its time.
std::map<std::string, std::string> picture(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string path = entry.path().string();
    files[path] = std::to_string(entry.last_write_time().time_since_epoch().count()) +
                  (entry.is_regular_file() ? hex(sha256(file_text(path))) : "");
  }
  return files;
}

/// What opening says in another process, where locks and claims are not this one's.
std::string elsewhere(const std::function<std::string()>& says) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string text = says();
    ::_exit(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  ::close(ends[1]);
  std::string text;
  char bytes[512];
  for (ssize_t size; (size = ::read(ends[0], bytes, sizeof bytes)) > 0;)
    text.append(bytes, static_cast<std::size_t>(size));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  return text;
}

std::string jobs_says(const ServiceConfig& config) {
  const auto jobs = JobService::open(config, [] {});
  return jobs ? "open" : jobs.error().message;
}

/// A claim holds on the whole computer: tests that run at the same time have other ports. Nothing listens
/// there.
const std::string kPort = std::to_string(1000 + ::getpid() % 5000);

/// Outlives the claims on it: its number may be another test's right after.
struct Terminal {
  const int fd = ::posix_openpt(O_RDWR | O_NOCTTY);
  const std::string name;
  Terminal() : name(::grantpt(fd) == 0 && ::unlockpt(fd) == 0 ? ::ptsname(fd) : "") {}
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal() { ::close(fd); }
};

class OneService : public testing::Test {
 protected:
  const Folder folder_{"state_lock"};
  const std::string mine_ = "process " + std::to_string(::getpid()) + " (";
};

TEST_F(OneService, C14TheSecondOfASpoolSaysWhoHasItAndChangesNothing) {
  const std::string spool = folder_.path + "/spool";
  const auto first = JobService::open(config_of(spool, "modbus-tcp:192.0.2.1:" + kPort), [] {});
  ASSERT_TRUE(first) << first.error().message;
  const auto before = picture(spool);
  EXPECT_GE(before.size(), 3u);
  std::filesystem::create_directory_symlink(spool, folder_.path + "/by-another-name");
  for (const std::string& name : {spool, folder_.path + "/by-another-name"}) {
    const ServiceConfig second = config_of(name, "modbus-tcp:192.0.2.2:" + kPort);
    for (const std::string& said : {jobs_says(second), elsewhere([&] { return jobs_says(second); })}) {
      EXPECT_NE(said.find("is in use by " + mine_), std::string::npos) << said;
      EXPECT_NE(said.find("nothing in it was changed"), std::string::npos) << said;
    }
  }
  EXPECT_EQ(picture(spool), before);
  // Somebody takes the file for a leftover.
  std::filesystem::remove(spool + "/lock");
  const std::string said = jobs_says(config_of(spool, "modbus-tcp:192.0.2.2:" + kPort));
  EXPECT_NE(said.find("is in use by another process"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(spool + "/lock"));
}

TEST_F(OneService, C14ALockDiesWithItsProcess) {
  const std::string spool = folder_.path + "/spool";
  const ServiceConfig config = config_of(spool, "modbus-tcp:192.0.2.1:" + kPort);
  EXPECT_EQ(elsewhere([&] { return jobs_says(config); }), "open");
  EXPECT_EQ(jobs_says(config), "open");
  EXPECT_EQ(jobs_says(config), "open") << "given back";
}

TEST_F(OneService, C14TwoNamesOfOneMachineAreRefused) {
  const Terminal terminal;
  const std::string device = terminal.name;
  ASSERT_NE(device, "");
  std::filesystem::create_symlink(device, folder_.path + "/by-id");
  std::filesystem::create_symlink("by-id", folder_.path + "/by-path");
  const std::vector<std::vector<std::string>> machines = {
      {"grbl:" + device + "@115200", "grbl:" + folder_.path + "/by-id",
       "modbus-rtu:" + folder_.path + "/by-path@9600/3"},
      {"grbl:" + folder_.path + "/absent", "grbl:" + folder_.path + "/x/../absent"},
      {"modbus-tcp:127.0.0.1:" + kPort, "modbus-tcp:localhost:" + kPort,
       "modbus-tcp:LOCALHOST:" + kPort + "/1", "drive-tcp:[::1]:" + kPort,
       "modbus-tcp:[::ffff:127.0.0.1]:" + kPort, "modbus-tcp:127.1:" + kPort, "modbus-tcp:0.0.0.0:" + kPort},
      {"modbus-tcp:192.0.2.9:" + kPort, "modbus-tcp:[::ffff:192.0.2.9]:" + kPort},
      {"modbus-tcp:a..invalid:" + kPort, "modbus-tcp:A..Invalid:" + kPort}};
  for (const auto& names : machines) {
    for (const std::string& first : names)
      for (const std::string& second : names) {
        MachineClaim one, two;
        ASSERT_TRUE(one.follow(link_to(first))) << first;
        ASSERT_TRUE(one.follow(link_to(second))) << "its own machine by another name";
        const auto refused = two.follow(link_to(first));
        ASSERT_FALSE(refused) << first << " and " << second;
        EXPECT_EQ(refused.error().code, Code::kUsage);
        EXPECT_NE(refused.error().message.find(mine_), std::string::npos) << refused.error().message;
      }
  }
  // Other machines are other machines.
  std::vector<MachineClaim> all(machines.size() + 2);
  for (std::size_t i = 0; i < machines.size(); ++i)
    EXPECT_TRUE(all[i].follow(link_to(machines[i].front()))) << machines[i].front();
  EXPECT_TRUE(all[machines.size()].follow(link_to("modbus-tcp:127.0.0.1:1" + kPort)));
  EXPECT_TRUE(all[machines.size() + 1].follow(link_to("modbus-tcp:127.0.0.1:" + kPort + "/2")));
}

/// A network board has a plain port and one for a WebSocket.
TEST_F(OneService, C14OneBoardIsOneMachineByBothOfItsWays) {
  const std::string plain = "grbl-tcp:192.0.2.77:" + kPort, other_plain = "grbl-tcp:192.0.2.77:1" + kPort,
                    socket = "grbl-ws:192.0.2.77:2" + kPort + "/ws",
                    mapped = "grbl-ws:[::ffff:192.0.2.77]:81";
  for (const auto& [first, second] :
       {std::pair(plain, socket), std::pair(socket, plain), std::pair(plain, mapped)}) {
    MachineClaim one, two;
    ASSERT_TRUE(one.follow(link_to(first)));
    const auto refused = two.follow(link_to(second));
    ASSERT_FALSE(refused) << first << " and " << second;
    EXPECT_NE(refused.error().message.find(mine_), std::string::npos) << refused.error().message;
    EXPECT_NE(elsewhere([&, link = link_to(second)] {
                MachineClaim three;
                return three.follow(link) ? std::string("open") : std::string("refused");
              }),
              "open");
    EXPECT_TRUE(one.follow(link_to(second))) << "its own board by the other way";
    EXPECT_TRUE(one.follow(link_to(first)));
  }
  // A server of serial ports has several machines, and a host of another kind is another machine.
  MachineClaim one, two, three, four;
  EXPECT_TRUE(one.follow(link_to(plain)));
  EXPECT_TRUE(two.follow(link_to(other_plain)));
  EXPECT_TRUE(three.follow(link_to("modbus-tcp:192.0.2.77:3" + kPort)));
  EXPECT_TRUE(four.follow(link_to("grbl-ws:192.0.2.78:" + kPort)));
  // On this computer there are simulations, not boards.
  MachineClaim near, beside;
  EXPECT_TRUE(near.follow(link_to("grbl-tcp:127.0.0.1:" + kPort)));
  EXPECT_TRUE(beside.follow(link_to("grbl-ws:127.0.0.1:2" + kPort)));
}

TEST_F(OneService, C14AClaimMovesWithItsDevice) {
  const Terminal terminal;
  const LinkSpec named = link_to("grbl:" + folder_.path + "/by-id"),
                 device = link_to("grbl:" + terminal.name);
  MachineClaim one, two;
  ASSERT_TRUE(one.follow(named)) << "not plugged in yet";
  ASSERT_TRUE(two.follow(device));
  std::filesystem::create_symlink(terminal.name, folder_.path + "/by-id");
  EXPECT_FALSE(one.follow(named)) << "the other has it";
  ASSERT_TRUE(two.follow(link_to("modbus-tcp:192.0.2.9:" + kPort))) << "which lets go of it";
  EXPECT_TRUE(one.follow(named));
  EXPECT_FALSE(two.follow(device));
}

/// A service at rest that keeps the number of a device that has gone keeps another's machine from it.
TEST_F(OneService, C14AServiceLetsGoOfADeviceThatHasGone) {
  const Terminal terminal;
  std::filesystem::create_symlink(terminal.name, folder_.path + "/by-id");
  auto service =
      JobService::open(config_of(folder_.path + "/spool", "grbl:" + folder_.path + "/by-id"), [] {});
  ASSERT_TRUE(service) << service.error().message;
  const LinkSpec device = link_to("grbl:" + terminal.name);
  MachineClaim other;
  service->tick();
  EXPECT_FALSE(other.follow(device)) << "it is there";
  std::filesystem::remove(folder_.path + "/by-id");
  service->tick();
  EXPECT_TRUE(other.follow(device));
  std::filesystem::create_symlink(terminal.name, folder_.path + "/by-id");
  service->tick();
  EXPECT_FALSE(MachineClaim().follow(device)) << "the other still has it";
}

TEST_F(OneService, C14AServiceOfTheSameMachineOpensNoSpool) {
  const auto first =
      JobService::open(config_of(folder_.path + "/spool", "modbus-tcp:localhost:" + kPort), [] {});
  ASSERT_TRUE(first) << first.error().message;
  const ServiceConfig second = config_of(folder_.path + "/other", "modbus-tcp:127.0.0.1:" + kPort);
  const std::string said = elsewhere([&] { return jobs_says(second); });
  EXPECT_NE(said.find(mine_), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(folder_.path + "/other"));
}

}  // namespace
}  // namespace tiltfeed
