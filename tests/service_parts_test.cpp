// The parts of the service one by one: requests, spool, black box, machine time, the map of blocks, re-entry.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "config/service_config.h"
#include "daemon/api.h"
#include "daemon/api_socket.h"
#include "daemon/black_box.h"
#include "daemon/block_map.h"
#include "daemon/job_runner.h"
#include "daemon/notify.h"
#include "daemon/program_walk.h"
#include "daemon/reentry.h"
#include "daemon/spool.h"
#include "sim/program.h"
#include "tests/sim_machine.h"

namespace tiltfeed {
namespace {

struct Folder {
  Folder() : path("/tmp/tiltfeed_parts_" + std::to_string(::getpid())) {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path + "/" + name) << text;
    return path + "/" + name;
  }
  std::string path;
};

// ---- requests ------------------------------------------------------------------------------------------

TEST(Api, RequestsComeBack) {
  ApiRequest request;
  request.op = ApiOp::kResume;
  request.job = 12;
  request.from = 345;
  request.confirmed = true;
  request.queue = true;
  std::string line = write_request(request);
  ASSERT_EQ(line.back(), '\n');
  line.pop_back();
  const auto read = parse_request(line);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->op, ApiOp::kResume);
  EXPECT_EQ(read->job, 12u);
  EXPECT_EQ(read->from, 345u);
  EXPECT_TRUE(read->confirmed);
  EXPECT_TRUE(read->queue);
}

TEST(Api, EveryKindOfBadRequestIsRefused) {
  const std::string deep(3000, '[');
  for (const std::string& line : {std::string(),
                                  std::string("{"),
                                  std::string("[]"),
                                  std::string("3"),
                                  std::string("{}"),
                                  std::string(R"({"v":2,"op":"list"})"),
                                  std::string(R"({"v":"1","op":"list"})"),
                                  std::string(R"({"v":1})"),
                                  std::string(R"({"v":1,"op":"format"})"),
                                  std::string(R"({"v":1,"op":7})"),
                                  std::string(R"({"v":1,"op":"start"})"),
                                  std::string(R"({"v":1,"op":"start","job":0})"),
                                  std::string(R"({"v":1,"op":"start","job":-1})"),
                                  std::string(R"({"v":1,"op":"start","job":1.5})"),
                                  std::string(R"({"v":1,"op":"start","job":1e30})"),
                                  std::string(R"({"v":1,"op":"start","job":18446744073709551615})"),
                                  std::string(R"({"v":1,"op":"start","job":"1"})"),
                                  std::string(R"({"v":1,"op":"start","job":1,"extra":1})"),
                                  std::string(R"({"v":1,"op":"list","name":{"a":1}})"),
                                  std::string(R"({"v":1,"op":"resume","job":1,"from":0})"),
                                  std::string(R"({"v":1,"op":"override","job":1,"percent":900})"),
                                  R"({"v":1,"op":"submit","name":")" + std::string(300, 'x') + "\"}",
                                  R"({"v":1,"op":"list","name":)" + deep,
                                  std::string(kMaxRequest + 1, ' '),
                                  std::string("{\"v\":1,\"op\":\"list\",\"name\":\"\xff\xfe\"}")}) {
    const auto read = parse_request(line);
    ASSERT_FALSE(read) << line.substr(0, 80);
    EXPECT_EQ(read.error().code, Code::kUsage);
  }
}

TEST(ApiSocket, KnowsTheUserTakesFilesAndDropsWhoTalksTooMuch) {
  const Folder folder;
  const std::string path = folder.path + "/api.sock";
  auto socket = ApiSocket::open(path);
  ASSERT_TRUE(socket) << socket.error().message;
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0660u);
  EXPECT_FALSE(ApiSocket::open(path)) << "a second service on the same socket";

  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const auto client = [&](const std::string& bytes) {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::send(fd, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    return fd;
  };
  const int good = client("hello\n"), loud = client(std::string(3 * kMaxRequest, 'x'));
  std::string heard;
  std::uint32_t user = ~0u;
  for (int turn = 0; turn < 20; ++turn) {
    std::vector<pollfd> polled;
    socket->add_to(polled);
    ::poll(polled.data(), polled.size(), 5);
    socket->serve(polled, [&](const std::string& line, std::uint32_t who, const std::vector<int>&) {
      heard = line;
      user = who;
      return std::string("answer\n");
    });
  }
  EXPECT_EQ(heard, "hello");
  EXPECT_EQ(user, ::getuid());
  char reply[20] = {};
  EXPECT_EQ(::recv(good, reply, sizeof reply, MSG_DONTWAIT), 7);
  EXPECT_LE(::recv(loud, reply, sizeof reply, MSG_DONTWAIT), 0);
  std::vector<pollfd> left;
  socket->add_to(left);
  EXPECT_EQ(left.size(), 2u) << "the listening socket and the client that behaves";
  ::close(good);
  ::close(loud);
}

// ---- spool ---------------------------------------------------------------------------------------------

TEST(Spool, KeepsJobsOverARestartAndMakesItsOwnNames) {
  const Folder folder;
  const std::string program = folder.write("x.nc", "G0X0\n");
  const int fd = ::open(program.c_str(), O_RDONLY);
  {
    auto spool = Spool::open(folder.path + "/spool");
    ASSERT_TRUE(spool) << spool.error().message;
    SpooledJob job;
    job.name = "../../etc/passwd'); DROP TABLE jobs;--";
    job.program = true;
    job.user = 7;
    const auto id = spool->add(job, {fd});
    ASSERT_TRUE(id) << id.error().message;
    auto found = spool->find(*id);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->name, "....etcpasswd DROP TABLE jobs--");
    found->state = JobState::kUncertain;
    found->note = "it's \"so\"\n";
    found->total = 1ull << 40;
    ASSERT_TRUE(spool->update(*found));
  }
  auto spool = Spool::open(folder.path + "/spool");
  ASSERT_TRUE(spool);
  const auto jobs = spool->list();
  ASSERT_TRUE(jobs);
  ASSERT_EQ(jobs->size(), 1u);
  EXPECT_EQ(jobs->front().state, JobState::kUncertain);
  EXPECT_EQ(jobs->front().note, "it's \"so\"\n");
  EXPECT_EQ(jobs->front().total, 1ull << 40);
  EXPECT_EQ(jobs->front().user, 7u);
  std::ifstream copy(spool->file(1, "program.nc"));
  std::string line;
  std::getline(copy, line);
  EXPECT_EQ(line, "G0X0");
  ASSERT_TRUE(spool->remove(1));
  EXPECT_FALSE(std::filesystem::exists(spool->folder_of(1)));
  EXPECT_EQ(spool->find(1).error().code, Code::kUsage);
  // Numbers are never used again: a journal of an old job cannot be taken for a new one's.
  SpooledJob next;
  next.program = true;
  EXPECT_EQ(*spool->add(next, {fd}), 2u);
  ::close(fd);
}

TEST(Spool, RefusesWhatIsNoFileAndLeavesNothing) {
  const Folder folder;
  auto spool = Spool::open(folder.path + "/spool");
  ASSERT_TRUE(spool);
  SpooledJob job;
  job.program = true;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  EXPECT_EQ(spool->add(job, {ends[0]}).error().code, Code::kInput);
  const int folder_fd = ::open(folder.path.c_str(), O_RDONLY);
  EXPECT_EQ(spool->add(job, {folder_fd}).error().code, Code::kInput);
  EXPECT_EQ(spool->add(job, {}).error().code, Code::kUsage);
  job.program = false;
  const int yaml = ::open(folder.write("big.yaml", "").c_str(), O_RDWR);
  ASSERT_EQ(::ftruncate(yaml, static_cast<off_t>(kMaxJobBytes + 1)), 0);
  EXPECT_EQ(spool->add(job, {yaml, yaml}).error().code, Code::kInput);
  EXPECT_TRUE(spool->list()->empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path + "/spool/jobs"));
  for (const int fd : {ends[0], ends[1], folder_fd, yaml}) ::close(fd);
}

TEST(Spool, ASymbolicLinkInItIsNotFollowed) {
  const Folder folder;
  auto spool = Spool::open(folder.path + "/spool");
  ASSERT_TRUE(spool);
  std::filesystem::create_directories(folder.path + "/outside");
  std::filesystem::create_directory_symlink(folder.path + "/outside", spool->folder_of(1));
  const int fd = ::open(folder.write("x.nc", "G0X0\n").c_str(), O_RDONLY);
  SpooledJob job;
  job.program = true;
  EXPECT_FALSE(spool->add(job, {fd}));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path + "/outside"));
  ::close(fd);
}

TEST(ServiceConfig, ReadsItsExampleAndNamesWhatIsWrong) {
  const auto example = load_service_config(std::string(SOURCE_DIR) + "/config/service.yaml");
  ASSERT_TRUE(example) << example.error().message;
  EXPECT_EQ(example->machine.model.name, "generic-ac");
  EXPECT_EQ(example->spool, "/var/lib/tiltfeed/generic-ac");
  const std::string path = std::string(SOURCE_DIR) + "/config/service.yaml";
  const auto typo =
      parse_service_config("machine: machines/generic-ac.yaml\nlink: a\nspool: s\nsockets: x\n", path);
  ASSERT_FALSE(typo);
  EXPECT_NE(typo.error().message.find("service.yaml:4:1"), std::string::npos) << typo.error().message;
  const auto no_link = parse_service_config("machine: machines/generic-ac.yaml\nspool: s\nsocket: x\n", path);
  ASSERT_FALSE(no_link);
  EXPECT_NE(no_link.error().message.find("link"), std::string::npos);
  const auto absent =
      parse_service_config("link: a\nmachine: /absent/mill.yaml\nspool: s\nsocket: x\n", path);
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().message.find(path + ":2:10: machine: /absent/mill.yaml: cannot read"), 0u)
      << absent.error().message;
}

// ---- log, black box, map -------------------------------------------------------------------------------

TEST(Notify, DatagramHasTheFieldsAndNobodyCanAddOne) {
  LogFields fields;
  fields.machine = "ac5";
  fields.job = 3;
  fields.block = 77;
  EXPECT_EQ(
      journal_datagram(Severity::kWarning, "a\nPRIORITY=0", fields),
      "MESSAGE=a?PRIORITY=0\nPRIORITY=4\nSYSLOG_IDENTIFIER=tiltfeed\nTILTFEED_MACHINE=ac5\nTILTFEED_JOB=3\n"
      "TILTFEED_BLOCK=77\n");
}

TEST(Notify, SendsToTheSocketOfSystemd) {
  const Folder folder;
  const std::string path = folder.path + "/notify";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  EXPECT_TRUE(notify("READY=1"));
  char bytes[20] = {};
  EXPECT_EQ(::recv(fd, bytes, sizeof bytes, MSG_DONTWAIT), 7);
  EXPECT_STREQ(bytes, "READY=1");
  ::unsetenv("NOTIFY_SOCKET");
  EXPECT_FALSE(notify("READY=1"));
  ::close(fd);
}

TEST(BlackBox, KeepsTheLastHundredLinesEachWayInOrder) {
  BlackBox box(false);
  for (int i = 0; i < 250; ++i) {
    box.take(Way::kOut, "G1X" + std::to_string(i) + "\n", std::chrono::milliseconds(i));
    box.take(Way::kIn, "o", Time{0});
    box.take(Way::kIn, "k\n", Time{0});
  }
  box.take(Way::kIn, "half\x01", Time{0});
  std::istringstream in(box.text());
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 201u);
  EXPECT_EQ(lines[0], "0.150000 > G1X150");
  EXPECT_EQ(lines[1], "0.000000 < ok");
  EXPECT_EQ(lines[198], "0.249000 > G1X249");
  EXPECT_EQ(lines[200], "(open) < half\\x01");
  BlackBox words(true);
  words.take(Way::kOut, std::string("\x01\x02\xff\x00", 4), Time{0});
  EXPECT_EQ(words.text(), "0.000000 > 0102 ff00 \n");
}

TEST(BlockMap, GivesMoveAndFacetOfEachBlock) {
  const Folder folder;
  JointPath joints;
  ToolPath path;
  for (std::uint32_t i = 0; i < 10; ++i)
    path.moves.push_back({{}, MoveKind::kCut, i == 3 ? kNoFacet : 100 + i});
  for (std::uint32_t i = 0; i < 20; ++i) joints.moves.push_back({{}, 0.0, MoveKind::kCut, i / 2});
  {
    std::ofstream out(folder.path + "/map", std::ios::binary);
    write_block_map(joints, path, out);
  }
  for (std::uint32_t i = 0; i < 20; ++i) {
    const auto origin = read_block_origin(folder.path + "/map", i + 1);
    ASSERT_TRUE(origin && *origin);
    EXPECT_EQ((*origin)->move, i / 2);
    EXPECT_EQ((*origin)->facet, i / 2 == 3 ? kNoFacet : 100 + i / 2);
  }
  EXPECT_FALSE(*read_block_origin(folder.path + "/map", 21));
  EXPECT_FALSE(*read_block_origin(folder.path + "/map", 0));
  EXPECT_EQ(read_block_origin(folder.write("no", "nonsense"), 1).error().code, Code::kInput);
}

// ---- machine time and re-entry -------------------------------------------------------------------------

constexpr const char* kProgram =
    "(TILTFEED part)\nG21 G90 G17 G40 G49 G54\nS8000 M3\nG0 X0 Y0 Z100 A0 C0\nG0 X60 A30 C400\nG0 "
    "Z20\nM8\nG93\n"
    "G1 Z10 F60\nX61 F120\nX62 C401 F120\nX63 F120\nG0 Z100\nG94\nM9\nM5\nM2\n";

TEST(ProgramTime, IsTheMachinesNotTheLines) {
  const Folder folder;
  const std::string path = folder.write("p.nc", kProgram);
  const auto time = ProgramTime::read(path, LinkKind::kModbusTcp, sim::test_machine());
  ASSERT_TRUE(time) << time.error().message;
  // Rapids at 1000 mm/s and 600 deg/s: 400/600 s, 80 and 90 mm; feeds of 1, 0.5, 0.5 and 0.5 s.
  EXPECT_NEAR(time->total(), 400.0 / 600 + 0.08 + 2.5 + 0.09, 1e-9);
  EXPECT_EQ(time->at(0), 0.0);
  EXPECT_EQ(time->at(1000), time->total());
  const auto block = find_block(path, LinkKind::kModbusTcp, sim::test_machine(), 7);
  ASSERT_TRUE(block);
  EXPECT_EQ(block->text, "X61F120");
  EXPECT_EQ(block->line, 10u);
  EXPECT_EQ(block->moves, 5u);
  EXPECT_NEAR(block->seconds, 400.0 / 600 + 0.08 + 1.5, 1e-9);
  EXPECT_EQ(find_block(path, LinkKind::kGrbl, sim::test_machine(), 7)->text, "G93");
  EXPECT_EQ(find_block(path, LinkKind::kGrbl, sim::test_machine(), 99).error().code, Code::kUsage);
}

TEST(ProgramTime, RemainingTimeFollowsTheMachine) {
  const Folder folder;
  std::string text = "G90\nG0 X0 Y0 Z0 A0 C0\nG93\n";
  for (int i = 0; i < 1000; ++i) text += "G1 X" + std::to_string(i % 2) + (i < 511 ? " F60\n" : " F20\n");
  const auto time =
      ProgramTime::read(folder.write("p.nc", text + "M2\n"), LinkKind::kModbusTcp, sim::test_machine());
  ASSERT_TRUE(time);
  EXPECT_NEAR(time->total(), 511 + 3 * 489, 1e-6);
  EXPECT_NEAR(remaining_seconds(*time, 512, 0.0, 511.0), 1467,
              0.01);  // half of the lines, a quarter of the time
  EXPECT_NEAR(remaining_seconds(*time, 512, 0.0, 1022.0), 2934,
              0.01);  // the machine takes twice as long as planned
  EXPECT_NEAR(remaining_seconds(*time, 512, 506.0, 900.0), 1467, 0.01);  // too little seen to scale
}

MachineProfile profile() {
  MachineProfile machine;
  machine.model = sim::test_machine();
  return machine;
}

std::vector<sim::Block> read_back(const std::string& text) {
  std::istringstream in(text);
  const auto blocks = sim::read_program(in, "text", 'A', 'C');
  EXPECT_TRUE(blocks) << blocks.error().message;
  return blocks ? *blocks : std::vector<sim::Block>{};
}

TEST(Reentry, EndsWhereTheBlockBeforeEndedAndGoesOnAsTheProgram) {
  const Folder folder;
  const std::string path = folder.write("p.nc", kProgram);
  const std::vector<sim::Block> whole = read_back(kProgram);
  for (std::uint64_t from = 3; from <= whole.size(); ++from) {
    ReentryOptions options;
    options.from = from;
    options.retract = 40.0;
    const auto entry = write_reentry(path, LinkKind::kModbusTcp, profile(), options);
    ASSERT_TRUE(entry) << entry.error().message;
    const std::vector<sim::Block> again = read_back(entry->program);
    const std::size_t rest = whole.size() - (from - 1);
    ASSERT_GT(again.size(), rest);
    for (std::size_t i = 0; i < rest; ++i) {
      const sim::Block &is = again[again.size() - rest + i], &was = whole[from - 1 + i];
      ASSERT_EQ(is.op, was.op) << from;
      ASSERT_EQ(is.m_code, was.m_code);
      ASSERT_EQ(is.target, was.target) << from << "+" << i;
      ASSERT_EQ(is.feed, was.feed);
      ASSERT_EQ(is.inverse_time, was.inverse_time);
    }
    // Where it stood before, spindle and coolant as they were.
    const sim::Block& last = again[again.size() - rest - 1];
    Joints before;
    bool spindle = false, coolant = false;
    for (std::size_t i = 0; i + 1 < from; ++i) {
      if (whole[i].op == sim::Op::kRapid || whole[i].op == sim::Op::kFeed) before = whole[i].target;
      if (whole[i].op == sim::Op::kMCode) spindle = whole[i].m_code == 3 || (spindle && whole[i].m_code != 5);
      if (whole[i].op == sim::Op::kMCode) coolant = whole[i].m_code == 8 || (coolant && whole[i].m_code != 9);
    }
    EXPECT_EQ(last.target, before) << from;
    bool turns = false;
    for (std::size_t i = 0; i + rest < again.size(); ++i) turns = turns || again[i].m_code == 3;
    EXPECT_EQ(turns, spindle) << from;
    bool flood = false;
    for (std::size_t i = 0; i + rest < again.size(); ++i) flood = flood || again[i].m_code == 8;
    EXPECT_EQ(flood, coolant) << from;
  }
}

TEST(FieldFailures, F19_UnsafeResume) {
  const Folder folder;
  ReentryOptions options;
  options.from = 10;
  options.retract = 40.0;
  options.plunge_feed = 150.0;
  const auto entry = write_reentry(folder.write("p.nc", kProgram), LinkKind::kGrbl, profile(), options);
  ASSERT_TRUE(entry) << entry.error().message;
  // A head tilted by 30 degrees about +X leans the tool towards -Y: 40 (0, -sin 30, cos 30).
  const std::string start =
      "(TILTFEED re-entry before block 10, line 11)\nG21 G90 G17 G40 G49 G54 G94\nG91\nG1 X0 Y-20 Z34.641 "
      "F150\nG90\n";
  ASSERT_EQ(entry->program.substr(0, start.size()), start) << entry->program;
  const std::string rest = entry->program.substr(start.size());
  EXPECT_EQ(
      rest.substr(0, rest.find("G93")),
      "G0 Z134.641\nG0 A30 C400\nG0 X61 Y-20\nS8000 M3\nM8\nG4 P3\nG1 Z44.641 F150\nG1 X61 Y0 Z10 F150\n");
  EXPECT_NE(rest.find("G93\nG1X62C401F120\nX63F120\nG0Z100\n"), std::string::npos) << rest;
  EXPECT_NE(entry->preview.find("1. retract 40 mm"), std::string::npos) << entry->preview;
}

TEST(Reentry, RefusesWhatItCannotVouchFor) {
  const Folder folder;
  const std::string path = folder.write("p.nc", kProgram);
  ReentryOptions options;
  const auto code = [&](const std::string& file) {
    const auto entry = write_reentry(file, LinkKind::kModbusTcp, profile(), options);
    return entry ? Code::kCancelled : entry.error().code;
  };
  for (const std::uint64_t from : {0, 1, 2, 99}) {
    options.from = from;
    EXPECT_EQ(code(path), Code::kUsage) << from;
  }
  options.from = 6;
  EXPECT_EQ(code(folder.write("arc.nc", std::string(kProgram) + "")), Code::kCancelled);
  EXPECT_EQ(
      code(folder.write("bad.nc", "G90\nG0 X0 Y0 Z0 A0 C0\nG2 X1 I1\nG0 X2\nG0 X3\nG0 X4\nG0 X5\nG0 X6\n")),
      Code::kInput);
  EXPECT_EQ(code(folder.write("far.nc", "G90\nG0 X0 Y-490 Z0 A80 C0\nG0 X2\nG0 X3\nG0 X4\nG0 X5\nG0 X6\n")),
            Code::kLimit);
}

}  // namespace
}  // namespace tiltfeed
