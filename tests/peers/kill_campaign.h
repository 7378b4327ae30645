#pragma once
// A sender that is killed at any step, again and again, against a simulated ring controller that lives on in
// the parent: real processes, a real socket, a real journal file. The same without processes for power loss,
// where only what was made durable is left.

#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/files/sha256.h"
#include "tests/judges/same_block.h"
#include "tests/peers/dying_sender.h"
#include "tests/peers/sim_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

/// One campaign's program: `blocks` short feed moves, each of its own place.
struct KillProgram {
  explicit KillProgram(int blocks, const std::string& folder) : path(folder + "/program.nc") {
    std::ostringstream out;
    out << "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG93\n";
    char line[100];
    for (int i = 1; i < blocks; ++i) {
      std::snprintf(line, sizeof line, "G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f F20000\n", i * 0.01, i % 7 * 0.1,
                    i % 5 * 0.1, i % 11 * 0.01, i * 0.02);
      out << line;
    }
    out << "M2\n";
    std::ofstream(path) << out.str();
    std::istringstream in(out.str());
    expected = *sim::read_program(in, path, 'A', 'C');
  }
  std::string path;
  std::vector<sim::Block> expected;
};

/// The controller, and what it executed.
struct RingMachine {
  RingMachine()
      : controller(sim::test_machine(), {}, {.ring = 24, .boot_id = 7},
                   [this](const sim::TraceRow& row) { executed.push_back(row.command); }) {}

  std::string serve(const std::string& bytes) {
    pass(0.0005);
    const ModbusRequest request = unpack_request(bytes);
    if (!request.words.empty()) {
      const auto access = controller.write(request.write_address, request.words);
      if (access != sim::Access::kOk) return pack_reply({static_cast<std::uint8_t>(access), {}});
    }
    ModbusReply reply{kReplyOk, std::vector<std::uint16_t>(request.read_count)};
    if (request.read_count > 0) controller.read(request.read_address, reply.words);
    return pack_reply(reply);
  }
  void pass(double seconds) {
    now += seconds;
    controller.advance_link(now);
    controller.advance(now);
  }
  /// As when its power fails: what its ring held is gone, and it starts with another boot_id.
  void restart() {
    std::vector<std::uint16_t> status(24);
    controller.read(sim::kStatusAt, status);
    const auto reset =
        encode_mailbox(status[2], static_cast<std::uint16_t>(status[11] + 1), MailboxCode::kReset, 0, false);
    controller.write(sim::kMailboxAt, reset);
  }

  std::vector<sim::Block> executed;
  double now = 0.0;
  sim::ModbusController controller;
};

/// Deaths of one program; then it is let live.
inline constexpr int kDeaths = 30;

/// A life in a process of its own, killed for real. The parent is the machine.
inline Outcome forked_life(const ProgramRun& run, const std::string& journal, bool& begun,
                           RingMachine& machine, Steps steps, Bug bug) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    return {End::kWrong, 0, 0, "socketpair"};
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    ScriptClock clock;
    DyingLink link(clock, steps);
    link.ask = [&](const std::string& request) {
      const std::string message = "R" + request;
      char reply[1024];
      if (::send(ends[1], message.data(), message.size(), 0) < 0 || steps.step()) ::_exit(9);
      const ssize_t size = ::recv(ends[1], reply, sizeof reply, 0);
      if (size <= 0) ::_exit(9);
      return std::string(reply, static_cast<std::size_t>(size));
    };
    link.wait_for = [&](Time wait) {
      const std::string message = "T" + std::to_string(wait.count());
      if (::send(ends[1], message.data(), message.size(), 0) < 0) ::_exit(9);
    };
    auto disk = journal_file(journal);
    const BegunMark mark{begun, [&] {
                           if (::send(ends[1], "B", 1, 0) < 0) ::_exit(9);
                         }};
    const Outcome outcome = disk ? sender_life(run, *disk, mark, link, clock, steps, bug)
                                 : Outcome{End::kWrong, 0, 0, disk.error().message};
    const std::string message = std::string("E") + static_cast<char>(outcome.end) +
                                std::to_string(outcome.executed) + " " + std::to_string(outcome.may_have) +
                                " " + outcome.text;
    ::_exit(::send(ends[1], message.data(), message.size(), 0) < 0 ? 9 : 0);
  }
  ::close(ends[1]);
  Outcome outcome{End::kKilled, 0, 0, "no word from the child"};
  char bytes[4096];
  for (ssize_t size; (size = ::recv(ends[0], bytes, sizeof bytes, 0)) > 0;) {
    const std::string message(bytes + 1, static_cast<std::size_t>(size - 1));
    if (bytes[0] == 'R') {
      const std::string reply = machine.serve(message);
      ::send(ends[0], reply.data(), reply.size(), MSG_NOSIGNAL);
    } else if (bytes[0] == 'B') {
      begun = true;
    } else if (bytes[0] == 'T') {
      machine.pass(std::stod(message) * 1e-9);
    } else {
      std::istringstream in(message.substr(1));
      outcome.end = static_cast<End>(message[0]);
      in >> outcome.executed >> outcome.may_have;
      std::getline(in, outcome.text);
    }
  }
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) return {End::kKilled, 0, 0, ""};
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return {End::kWrong, 0, 0, "the child ended with " + std::to_string(status)};
  return outcome;
}

/// A life that the power ends, in this process.
inline Outcome powered_life(const ProgramRun& run, const std::shared_ptr<SimulatedDisk>& disk, bool& begun,
                            RingMachine& machine, Steps steps, Bug bug) {
  ScriptClock clock;
  steps.power = true;
  DyingLink link(clock, steps);
  link.ask = [&](const std::string& request) { return machine.serve(request); };
  link.wait_for = [&](Time wait) { machine.pass(std::chrono::duration<double>(wait).count()); };
  return sender_life(run, journal_disk(disk), {begun, [&] { begun = true; }}, link, clock, steps, bug);
}

struct Campaign {
  bool power = false;
  Bug bug = Bug::kNone;
  int restarts_in = 0;       ///< one of so many deaths takes the controller along; 0: none
  bool new_program = false;  ///< the file is another one from the second life on
  std::uint64_t seed = 1;

  std::uint64_t kills = 0, runs = 0, uncertain = 0, wrong = 0;
  std::string first_wrong = {};

  void complain(const std::string& text) {
    if (wrong++ == 0) first_wrong = text;
  }

  /// One program from its start to its end through any number of deaths.
  void run(const ProgramRun& prepared, const KillProgram& program, const std::string& folder) {
    std::mt19937_64 random(seed++);
    RingMachine machine;
    ProgramRun job = prepared;
    const std::string journal = folder + "/journal";
    std::filesystem::remove(journal);
    const auto disk = std::make_shared<SimulatedDisk>();
    bool restarted = false, begun = false;
    Outcome outcome;
    ++runs;
    for (int life = 0; life <= kDeaths; ++life) {
      Steps steps;
      steps.at = life < kDeaths ? 1 + random() % 140 : ~0ull;
      steps.torn = random();
      outcome = power ? powered_life(job, disk, begun, machine, steps, bug)
                      : forked_life(job, journal, begun, machine, steps, bug);
      if (outcome.end != End::kKilled) break;
      ++kills;
      machine.pass(static_cast<double>(random() % 2500) * 1e-3);
      if (restarts_in > 0 && random() % static_cast<std::uint64_t>(restarts_in) == 0) {
        machine.restart();
        restarted = true;
      }
      if (power) {
        disk->file = disk->durable = disk->after_power_loss(random);
        ++job.subject.host[0];
      }
      if (new_program) replace_program(job);
    }
    judge(machine, program, outcome, restarted);
  }

  /// The same blocks in another file.
  static void replace_program(ProgramRun& job) {
    const std::string other = job.program + ".other";
    std::filesystem::copy_file(job.program, other, std::filesystem::copy_options::overwrite_existing);
    std::ofstream(other, std::ios::app) << "(another)\n";
    job.program = other;
    job.subject.program = sha256(file_text(other));
  }

  void judge(const RingMachine& machine, const KillProgram& program, const Outcome& outcome, bool restarted) {
    const std::string place = " (seed " + std::to_string(seed - 1) + ", " + outcome.text + ")";
    const std::size_t count = machine.executed.size();
    for (std::size_t i = 0; i < count; ++i)
      if (i >= program.expected.size() || !same_block(machine.executed[i], program.expected[i]))
        return complain("block " + std::to_string(i + 1) + " is not the program's" + place);
    switch (outcome.end) {
      case End::kDone:
        if (count != program.expected.size())
          complain("done after " + std::to_string(count) + " blocks" + place);
        return;
      case End::kUncertain:
        ++uncertain;
        if (!restarted && !new_program) return complain("stopped without need" + place);
        if (outcome.executed > count || outcome.may_have < count)
          complain("the operator is told " + std::to_string(outcome.executed) + " to " +
                   std::to_string(outcome.may_have) + ", in truth " + std::to_string(count) + place);
        return;
      case End::kKilled:
        return complain("never came to an end" + place);
      case End::kWrong:
        return complain("stuck" + place);
    }
  }
};

}  // namespace tiltfeed
