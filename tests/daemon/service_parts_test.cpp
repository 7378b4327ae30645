// The parts of the service one by one: requests, spool, settings, log, black box, the map of blocks.

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
#include "daemon/post/block_map.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"
#include "daemon/service/entry_mark.h"
#include "daemon/service/notify.h"
#include "daemon/service/spool.h"
#include "daemon/stream/wire_log.h"
#include "tests/peers/spool_add.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

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
  const Folder folder("parts");
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
    std::uint64_t asks = 0;
    const ApiTaker take = [&](Asked asked) { heard = asked.line, user = asked.user, asks = asked.client; };
    socket->serve(polled, take);
    if (asks != 0) socket->reply(asks, "answer\n", take);
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
  const Folder folder("parts");
  const std::string program = folder.write("x.nc", "G0X0\n");
  const int fd = ::open(program.c_str(), O_RDONLY);
  {
    auto spool = Spool::open(folder.path + "/spool");
    ASSERT_TRUE(spool) << spool.error().message;
    SpooledJob job;
    job.name = "../../etc/passwd'); DROP TABLE jobs;--";
    job.program = true;
    job.user = 7;
    const auto id = add_job(*spool, job, {fd});
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
  EXPECT_EQ(*add_job(*spool, next, {fd}), 2u);
  ::close(fd);
}

TEST(Spool, NamesKeepLettersOfEveryAlphabetWhole) {
  EXPECT_EQ(plain_name("Kühlstift Größe 3"), "Kühlstift Größe 3");
  EXPECT_EQ(plain_name("ручка/零件\n\x1b[31m"), "ручка零件31m");
  EXPECT_EQ(plain_name("\u202Ecn.exe\u2028"), "cn.exe") << "what turns the line is no letter";
  EXPECT_EQ(plain_name("ü\xC3"), "ü") << "half a letter is none";
  EXPECT_EQ(plain_name("\u00A0\u0085"), "job");
  for (std::size_t most = 1; most < 12; ++most)
    EXPECT_EQ(plain_name("零件零", most), most < 3 ? "job" : most < 6 ? "零" : most < 9 ? "零件" : "零件零");
}

/// A job of 5 blocks of its own, then blocks 96 to 100 of job 3.
TEST(EntryMark, B9TellsBlocksInNumbersOfTheEnteredJob) {
  const Folder folder("parts");
  const std::string file = folder.path + "/entry";
  EXPECT_FALSE(read_entry_mark(file));
  ASSERT_TRUE(write_entry_mark(file, {3, 96, 100}));
  const auto mark = read_entry_mark(file);
  ASSERT_TRUE(mark);
  EXPECT_EQ(entered_range(*mark, 0, 5, 10), "of job 3 none has run again");
  EXPECT_EQ(entered_range(*mark, 2, 6, 10), "of job 3 that is block 96");
  EXPECT_EQ(entered_range(*mark, 6, 8, 10), "of job 3 that is blocks 97 to 98");
  EXPECT_EQ(entered_range(*mark, 8, 10, 10), "of job 3 that is blocks 99 to 100");
  EXPECT_EQ(entered_range(*mark, 7, 7, 10), "of job 3 blocks 96 to 97 ran again");
}

TEST(Spool, RefusesWhatIsNoFileAndLeavesNothing) {
  const Folder folder("parts");
  auto spool = Spool::open(folder.path + "/spool");
  ASSERT_TRUE(spool);
  SpooledJob job;
  job.program = true;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  EXPECT_EQ(add_job(*spool, job, {ends[0]}).error().code, Code::kInput);
  const int folder_fd = ::open(folder.path.c_str(), O_RDONLY);
  EXPECT_EQ(add_job(*spool, job, {folder_fd}).error().code, Code::kInput);
  EXPECT_EQ(add_job(*spool, job, {}).error().code, Code::kUsage);
  job.program = false;
  const int yaml = ::open(folder.write("big.yaml", "").c_str(), O_RDWR);
  ASSERT_EQ(::ftruncate(yaml, static_cast<off_t>(kMaxJobBytes + 1)), 0);
  EXPECT_EQ(add_job(*spool, job, {yaml, yaml}).error().code, Code::kInput);
  EXPECT_TRUE(spool->list()->empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path + "/spool/jobs"));
  for (const int fd : {ends[0], ends[1], folder_fd, yaml}) ::close(fd);
}

TEST(Spool, ASymbolicLinkInItIsNotFollowed) {
  const Folder folder("parts");
  auto spool = Spool::open(folder.path + "/spool");
  ASSERT_TRUE(spool);
  std::filesystem::create_directories(folder.path + "/outside");
  std::filesystem::create_directory_symlink(folder.path + "/outside", spool->folder_of(1));
  const int fd = ::open(folder.write("x.nc", "G0X0\n").c_str(), O_RDONLY);
  SpooledJob job;
  job.program = true;
  EXPECT_TRUE(add_job(*spool, job, {fd}));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path + "/outside"));
  EXPECT_FALSE(std::filesystem::is_symlink(spool->folder_of(1)));
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

TEST(Notify, TheJournalHasTheFieldsAndNobodyCanAddOne) {
  LogFields fields;
  fields.machine = "ac5";
  fields.job = 3;
  fields.block = 77;
  EXPECT_EQ(journal_fields(Severity::kWarning, "a\nPRIORITY=0", fields),
            (std::vector<std::string>{"MESSAGE=a?PRIORITY=0", "PRIORITY=4", "SYSLOG_IDENTIFIER=tiltfeed",
                                      "TILTFEED_MACHINE=ac5", "TILTFEED_JOB=3", "TILTFEED_BLOCK=77"}));
}

TEST(Notify, SendsToTheSocketOfSystemd) {
  const Folder folder("parts");
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

TEST(WireLog, KeepsTheLastHundredLinesEachWayInOrder) {
  WireLog box(false);
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
  WireLog words(true);
  words.take(Way::kOut, std::string("\x01\x02\xff\x00", 4), Time{0});
  EXPECT_EQ(words.text(), "0.000000 > 0102 ff00 \n");
}

TEST(BlockMap, GivesMoveAndFacetOfEachBlock) {
  const Folder folder("parts");
  JointPath joints;
  ToolPath path;
  for (std::uint32_t i = 0; i < 10; ++i)
    path.moves.push_back({{}, MoveKind::kCut, i == 3 ? kNoFacet : 100 + i});
  for (std::uint32_t i = 0; i < 20; ++i) joints.moves.push_back({{}, 0.0, MoveKind::kCut, i / 2});
  {
    std::ofstream out(folder.path + "/map", std::ios::binary);
    Posting posting;
    posting.operations.emplace_back().words = &joints;
    write_block_map(posting, {&path}, out);
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

}  // namespace
}  // namespace tiltfeed
