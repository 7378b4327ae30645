// The journal: every byte of a record matters, torn tails of every length, failures at every operation,
// clocks that jump; and what is concluded from it.

#include "daemon/journal/journal.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "daemon/files/sha256.h"
#include "daemon/journal/run_recorder.h"
#include "tests/peers/journal_subject.h"
#include "tests/peers/simulated_disk.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

RunRecord sample(std::uint64_t n) {
  RunRecord r;
  r.event = RunEvent::kStreaming;
  r.link = 1;
  r.session_id = 0x1234;
  r.boot_id = 77;
  r.run = 3;
  r.job = 9;
  r.total = 1u << 20;
  r.reserved = 900 + n;
  r.offered = 800 + n;
  r.acknowledged = 700 + n;
  r.executed = 600 + n;
  r.wall_ms = -5;
  for (std::size_t i = 0; i < r.program.size(); ++i) r.program[i] = static_cast<std::uint8_t>(i * 7);
  for (std::size_t i = 0; i < r.host.size(); ++i) r.host[i] = static_cast<std::uint8_t>(200 + i);
  return r;
}

std::string bytes_of(std::uint64_t records) {
  std::string bytes;
  for (std::uint64_t i = 0; i < records; ++i) {
    const auto one = encode_record(sample(i), i);
    bytes.append(one.data(), one.size());
  }
  return bytes;
}

std::string empties(std::uint64_t first, std::uint64_t last) {
  std::string bytes;
  for (std::uint64_t i = first; i < last; ++i) {
    const auto one = encode_empty(i);
    bytes.append(one.data(), one.size());
  }
  return bytes;
}

TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(hex(sha256("")), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hex(sha256("abc")), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hex(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hex(sha256(std::string(1000000, 'a'))),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(JournalRecord, ComesBackAndEveryFlippedBitIsSeen) {
  const RunRecord record = sample(5);
  const auto bytes = encode_record(record, 41);
  ASSERT_EQ(decode_record({bytes.data(), bytes.size()}, 41), record);
  EXPECT_FALSE(decode_record({bytes.data(), bytes.size()}, 40)) << "a record in another's place";
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      auto damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ 1 << bit);
      ASSERT_FALSE(decode_record({damaged.data(), damaged.size()}, 41)) << i << "." << bit;
    }
  }
}

TEST(Journal, BytesThatAreCutOffAtAnyPlaceAreNeverAWholeJournal) {
  const std::string whole = bytes_of(3) + empties(3, 5);
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    const auto disk = std::make_shared<SimulatedDisk>();
    disk->file = whole.substr(0, length);
    auto journal = Journal::open(journal_disk(disk));
    ASSERT_TRUE(journal);
    const std::uint64_t records = std::min<std::uint64_t>(3, length / kRecordBytes);
    const JournalContent& content = journal->content();
    ASSERT_EQ(content.records, records);
    ASSERT_EQ(content.last.has_value(), records > 0);
    ASSERT_EQ(content.whole(), length >= 4 * kRecordBytes) << length;
    if (records > 0) {
      ASSERT_EQ(content.last->executed, 600 + records - 1);
    }
    // What is not whole is replaced at once.
    ASSERT_TRUE(journal->append(sample(records)));
    const JournalContent after = read_journal(disk->file);
    ASSERT_TRUE(after.whole());
    ASSERT_EQ(after.last, sample(records));
  }
}

TEST(Journal, ADamagedRecordBeforeWholeOnesIsCountedAndTakesNothingBack) {
  std::string bytes = bytes_of(4) + empties(4, 5);
  bytes[kRecordBytes + 20] ^= 1;
  const JournalContent content = read_journal(bytes);
  EXPECT_EQ(content.records, 4u);
  EXPECT_EQ(content.damaged, 1u);
  EXPECT_EQ(content.lost, 0u);
  EXPECT_EQ(content.last->reserved, 903u);
}

TEST(Journal, DamagedRecordsAfterTheNewestWholeOneAreCounted) {
  std::string bytes = bytes_of(4) + empties(4, 6);
  bytes[3 * kRecordBytes + 20] ^= 1;
  EXPECT_EQ(read_journal(bytes).lost, 1u);
  bytes[4 * kRecordBytes + 20] ^= 1;  // an empty slot that is damaged could have been a record
  EXPECT_EQ(read_journal(bytes).lost, 2u);
  EXPECT_EQ(read_journal(bytes).records, 3u);
  EXPECT_TRUE(read_journal(bytes).ended);
}

TEST(Journal, RecordsOfAnotherRunOrWithImpossibleFiguresAreNotBelieved) {
  RunRecord other = sample(4);
  ++other.run;
  RunRecord less = sample(4), more = sample(4), beyond = sample(4);
  less.offered = less.acknowledged - 1;
  more.executed = more.acknowledged + 1;
  beyond.total = beyond.reserved - 1;
  for (const RunRecord& record : {other, less, more, beyond}) {
    const auto wrong = encode_record(record, 4);
    const JournalContent content =
        read_journal(bytes_of(4) + std::string(wrong.data(), wrong.size()) + empties(5, 6));
    EXPECT_EQ(content.last, sample(3));
    EXPECT_EQ(content.lost, 1u);
  }
}

TEST(Journal, FiguresOfARunNeverShrink) {
  std::string bytes = bytes_of(2);
  RunRecord low = sample(0);
  low.reserved = low.offered = low.acknowledged = low.executed = 1;
  const auto third = encode_record(low, 2);
  bytes.append(third.data(), third.size());
  EXPECT_EQ(read_journal(bytes).last->reserved, 901u);
  EXPECT_EQ(read_journal(bytes).last->executed, 601u);
}

TEST(Journal, AFullFileHasGrownDurablyBeforeItsLastSlotIsUsed) {
  const auto disk = std::make_shared<SimulatedDisk>();
  Journal journal = *Journal::open(journal_disk(disk));
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(journal.append(sample(0)));
    ASSERT_GT(disk->durable.size(), journal.content().records * kRecordBytes) << "nothing shows the end";
  }
}

TEST(Journal, StaysSmall) {
  const auto disk = std::make_shared<SimulatedDisk>();
  auto journal = Journal::open(journal_disk(disk));
  ASSERT_TRUE(journal);
  RunRecord record = sample(0);
  for (int i = 0; i < 200000; ++i) {
    record.offered = ++record.reserved;
    ASSERT_TRUE(journal->append(record));
    ASSERT_LE(disk->file.size(), 9u << 20);
  }
  EXPECT_EQ(read_journal(disk->file).last, record);
}

TEST(JournalFile, RealFileIsLockedShortenedAndReadAgain) {
  const Folder folder("journal");
  const std::string path = folder.path + "/1.journal";
  {
    auto disk = journal_file(path);
    ASSERT_TRUE(disk) << disk.error().message;
    const auto second = journal_file(path);
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
    auto journal = Journal::open(*disk);
    ASSERT_TRUE(journal);
    for (std::uint64_t i = 0; i < 5; ++i) ASSERT_TRUE(journal->append(sample(i)));
    ASSERT_TRUE(journal->sync());
    ASSERT_TRUE(journal->start_with(sample(7)));
    EXPECT_FALSE(journal_file(path)) << "still locked after the file was replaced";
  }
  auto journal = Journal::open(*journal_file(path));
  ASSERT_TRUE(journal);
  EXPECT_EQ(journal->content().last, sample(7));
  EXPECT_TRUE(journal->content().whole());
  EXPECT_LT(std::filesystem::file_size(path), 100 * kRecordBytes);
  EXPECT_EQ(std::filesystem::status(path).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_FALSE(journal_file(folder.path + "/none/1.journal"));
}

// ---- while it streams ----------------------------------------------------------------------------------

/// The last record of the file, and nothing where anything of the file is not whole.
std::optional<RunRecord> newest(const std::string& bytes) {
  const JournalContent content = read_journal(bytes);
  if (!content.whole()) return std::nullopt;
  return decode_record(std::string_view(bytes).substr((content.records - 1) * kRecordBytes, kRecordBytes),
                       content.records - 1);
}

/// A run of `total` blocks, a few a turn, in the given time; false as soon as the journal fails. After every
/// turn in which blocks may leave, what a crash or a power loss would leave behind is judged.
bool stream(Journal& journal, const SimulatedDisk& disk, const RunSubject& subject,
            const std::vector<Time>& times) {
  auto recorder = RunRecorder::begin(journal, subject);
  if (!recorder) return false;
  SendState state;
  state.total = subject.total;
  std::uint64_t offered = 0, granted = 0;
  for (std::size_t turn = 0; state.executed < subject.total; ++turn) {
    const Time now = times[turn % times.size()];
    if (turn == 3) state.boot = 55;
    if (turn > 3) {
      for (std::uint64_t more = turn % 9; more > 0 && offered < subject.total; --more) {
        if (offered == granted) {
          const auto upto = recorder->reserve(offered + 1, now);
          if (!upto) return false;
          granted = *upto;
        }
        ++offered;
      }
      const std::uint64_t behind = offered == subject.total ? 0 : 4;
      state.acknowledged = offered - std::min(offered, behind);
      state.executed = std::min(state.acknowledged, state.executed + turn % 9);
    }
    if (!recorder->progress(state, now)) return false;
    const auto killed = newest(disk.file), later = newest(disk.durable);
    if (!killed || !later) return ADD_FAILURE() << "no whole record", false;
    EXPECT_GE(killed->offered, offered);
    EXPECT_LE(killed->offered, offered + kOfferSlack);
    EXPECT_GE(later->reserved, offered) << "left before it was durable";
    EXPECT_LE(killed->executed, state.executed);
    if (offered > 0) {
      EXPECT_EQ(later->boot_id, 55);
    }
    if (state.executed == subject.total) {
      EXPECT_EQ(later->executed, subject.total);
      EXPECT_EQ(later->event, RunEvent::kExecuted);
    }
  }
  return bool(recorder->end(RunEvent::kExecuted, state));
}

TEST(RunRecorder, NothingLeavesBeforeItIsDurableWhateverTheClockDoes) {
  const std::vector<std::vector<Time>> clocks = {
      {Time{0}},                                        // stands still
      {seconds(1), seconds(2), seconds(3)},             // goes back again and again
      {seconds(0), seconds(86400 * 3650), seconds(1)},  // ten years, and back
      {milliseconds(1), milliseconds(2), milliseconds(700), milliseconds(5000)}};
  for (const auto& times : clocks) {
    const auto disk = std::make_shared<SimulatedDisk>();
    auto journal = Journal::open(journal_disk(disk));
    ASSERT_TRUE(journal);
    ASSERT_TRUE(stream(*journal, *disk, subject_of(2000), times));
  }
}

TEST(RunRecorder, AFailureOfAnyDiskOperationStopsTheRun) {
  for (const int failure : {EIO, ENOSPC, 0}) {
    int survived = 0;
    for (int at = 0; survived == 0; ++at) {
      ASSERT_LT(at, 5000);
      const auto disk = std::make_shared<SimulatedDisk>();
      disk->fail_at = at;
      disk->failure = failure;
      disk->short_by = static_cast<std::size_t>(at) % kRecordBytes + 1;
      auto journal = Journal::open(journal_disk(disk));
      if (!journal) continue;
      if (stream(*journal, *disk, subject_of(600), {milliseconds(0), milliseconds(40), milliseconds(80)})) {
        ++survived;
        continue;
      }
      // Broken for good, and says why; what is on the disk can be read and continued.
      const Result<void> again = journal->append(sample(1));
      ASSERT_FALSE(again);
      EXPECT_EQ(again.error().code, Code::kIo);
      EXPECT_NE(again.error().message.find("journal cannot be"), std::string::npos);
      disk->fail_at = -1;
      ASSERT_TRUE(Journal::open(journal_disk(disk)));
    }
    EXPECT_EQ(survived, 1);
  }
}

// ---- what is concluded ---------------------------------------------------------------------------------

JournalContent content_of(RunRecord record) { return {record, 1, 0, 0, true}; }

RunRecord cut_off(const RunSubject& subject) {
  RunRecord r;
  r.event = RunEvent::kStreaming;
  r.link = static_cast<std::uint8_t>(subject.link);
  r.session_id = subject.session_id;
  r.boot_id = 5;
  r.run = 1;
  r.total = subject.total;
  r.program = subject.program;
  r.host = subject.host;
  r.reserved = 400;
  r.offered = 320;
  r.acknowledged = 310;
  r.executed = 300;
  return r;
}

TEST(DecideResume, WhatCanBeProvedIsContinued) {
  const RunSubject now = subject_of(1000);
  RunRecord r = cut_off(now);
  ResumeDecision d = decide_resume(content_of(r), now);
  EXPECT_EQ(d.way, ResumeWay::kContinue);
  EXPECT_EQ(d.ring.session, 99);
  EXPECT_EQ(d.ring.boot, 5);
  EXPECT_EQ(d.ring.accepted, 310u);
  EXPECT_EQ(d.ring.reserved, 320u);
  // The host was off: only the reservation is sure. Also where a record is damaged.
  RunSubject rebooted = now;
  rebooted.host[3] = 9;
  EXPECT_EQ(decide_resume(content_of(r), rebooted).ring.reserved, 400u);
  EXPECT_EQ(decide_resume({r, 5, 1, 0, true}, now).ring.reserved, 400u);
  r.offered = r.reserved = r.acknowledged = r.executed = 0;
  EXPECT_EQ(decide_resume(content_of(r), now).way, ResumeWay::kFresh);
  r = cut_off(now);
  r.executed = 1000;
  EXPECT_EQ(decide_resume(content_of(r), now).way, ResumeWay::kFinished);
}

TEST(DecideResume, NothingElseResumesByItself) {
  const RunSubject grbl = subject_of(1000, LinkKind::kGrbl);
  ResumeDecision d = decide_resume(content_of(cut_off(grbl)), grbl);
  EXPECT_EQ(d.way, ResumeWay::kUncertain);
  EXPECT_EQ(d.executed, 300u);
  EXPECT_EQ(d.may_have, 320u);
  EXPECT_NE(d.text.find("blocks 301 to 320 may have run"), std::string::npos) << d.text;
  EXPECT_NE(d.text.find("--from"), std::string::npos);

  const RunSubject now = subject_of(1000);
  RunSubject other = now;
  other.program = sha256("another");
  EXPECT_EQ(decide_resume(content_of(cut_off(now)), other).way, ResumeWay::kUncertain);
  other = now;
  other.total = 999;
  EXPECT_EQ(decide_resume(content_of(cut_off(now)), other).way, ResumeWay::kUncertain);
  other = now;
  other.link = LinkKind::kGrbl;
  EXPECT_EQ(decide_resume(content_of(cut_off(now)), other).way, ResumeWay::kUncertain);
  EXPECT_EQ(decide_resume(content_of(cut_off(other)), now).way, ResumeWay::kUncertain);
  RunRecord r = cut_off(now);
  r.boot_id = 0;
  EXPECT_EQ(decide_resume(content_of(r), now).way, ResumeWay::kUncertain);
  r = cut_off(now);
  r.total = 100000;
  r.reserved = r.offered = 40000;
  RunSubject large = subject_of(100000);
  EXPECT_EQ(decide_resume(content_of(r), large).way, ResumeWay::kUncertain) << "more than half the numbers";
}

TEST(RunRecorder, AControllerThatClaimsMoreThanLeftIsNotBelieved) {
  const auto disk = std::make_shared<SimulatedDisk>();
  Journal journal = *Journal::open(journal_disk(disk));
  RunRecorder recorder = *RunRecorder::begin(journal, subject_of(1000));
  const std::uint64_t granted = *recorder.reserve(1, Time{0});
  SendState state;
  state.total = 1000;
  state.boot = 5;
  state.acknowledged = state.executed = granted + 1;
  ASSERT_TRUE(recorder.progress(state, Time{0}));
  EXPECT_EQ(read_journal(disk->file).last->executed, granted);
  EXPECT_TRUE(read_journal(disk->file).whole());
}

TEST(RunRecorder, AxesThatStoodElsewhereAreRememberedWithTheRun) {
  const auto disk = std::make_shared<SimulatedDisk>();
  Journal journal = *Journal::open(journal_disk(disk));
  const RunSubject subject = subject_of(1000);
  RunRecorder recorder = *RunRecorder::begin(journal, subject);
  const std::uint64_t granted = *recorder.reserve(1, Time{0});
  SendState state;
  state.total = 1000;
  state.boot = 5;
  state.acknowledged = granted;
  state.executed = granted - 1;
  ASSERT_TRUE(recorder.progress(state, Time{0}));
  const ResumeDecision before = decide_resume(read_journal(disk->file), subject);
  EXPECT_NE(range_text(before, 1000).find("earlier ones have,"), std::string::npos);
  state.elsewhere = true;
  ASSERT_TRUE(recorder.end(RunEvent::kFault, state));
  // The next run of this program is killed before it has read the axes.
  Journal again = *Journal::open(journal_disk(disk));
  RunRecorder next = *RunRecorder::go_on(again, subject, granted);
  state.elsewhere = false;
  ASSERT_TRUE(next.progress(state, Time{0}));
  const ResumeDecision after = decide_resume(read_journal(disk->file), subject);
  EXPECT_EQ(after.executed, granted - 1);
  EXPECT_NE(range_text(after, 1000).find("earlier ones may not have"), std::string::npos)
      << range_text(after, 1000);
}

TEST(RunRecorder, BlocksThatTheProgramDidNotHaveWhenItWasCountedDoNotLeave) {
  const auto disk = std::make_shared<SimulatedDisk>();
  Journal journal = *Journal::open(journal_disk(disk));
  RunRecorder recorder = *RunRecorder::begin(journal, subject_of(3));
  ASSERT_EQ(*recorder.reserve(1, Time{0}), 3u);
  EXPECT_FALSE(recorder.reserve(4, Time{0}));
}

}  // namespace
}  // namespace tiltfeed
