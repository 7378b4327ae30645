// Which runs of a history are news: a service that is made up here, asked in pages, restarted, restored.
#include "desk/webhooks/run_cursor.h"

#include <gtest/gtest.h>

namespace tiltfeed::desk {
namespace {

struct History {
  std::vector<ToldRun> runs;
  std::size_t page = 1000;

  void add(std::uint64_t run, std::int64_t began, const std::string& outcome) {
    ToldRun one;
    one.run = run;
    one.began = began;
    one.outcome = outcome;
    runs.push_back(one);
  }
  HistoryPage after(std::uint64_t from) const {
    HistoryPage found;
    for (const ToldRun& run : runs)
      if (run.run > from && found.runs.size() < page) found.runs.push_back(run);
    found.more = found.runs.size() == page;
    return found;
  }
};

/// Asks until there is nothing more; the numbers of the news.
std::vector<std::uint64_t> read(RunCursor& cursor, const History& history, RunMark* mark = nullptr,
                                bool* anew = nullptr) {
  std::vector<std::uint64_t> told;
  for (int asked = 0; asked < 10'000; ++asked) {
    const auto news = cursor.take(history.after(cursor.ask_from()));
    if (!news) continue;
    for (const ToldRun& run : news->ended) told.push_back(run.run);
    if (mark) *mark = news->mark;
    if (anew) *anew = *anew || news->anew;
    if (!news->more) return told;
  }
  ADD_FAILURE() << "it does not end";
  return told;
}

using Numbers = std::vector<std::uint64_t>;

TEST(RunCursor, what_ended_before_the_first_contact_is_passed_over) {
  for (const std::size_t page : {2u, 3u, 1000u}) {
    History history{{}, page};
    RunCursor cursor(std::nullopt);
    history.add(1, 100, "done");
    history.add(2, 200, "stopped");
    history.add(3, 300, "running");
    EXPECT_EQ(read(cursor, history), Numbers{}) << page;
    ASSERT_TRUE(cursor.on_machine());
    EXPECT_EQ(cursor.on_machine()->run, 3u);
    EXPECT_EQ(read(cursor, history), Numbers{}) << page;
    history.runs[2].outcome = "done";
    EXPECT_EQ(read(cursor, history), Numbers{3}) << page;
    EXPECT_FALSE(cursor.on_machine());
    EXPECT_EQ(read(cursor, history), Numbers{}) << page;
    history.add(4, 400, "uncertain");
    history.add(5, 500, "done");
    EXPECT_EQ(read(cursor, history), (Numbers{4, 5})) << page;
  }
}

TEST(RunCursor, an_empty_history_is_a_first_contact_too) {
  History history;
  RunCursor cursor(std::nullopt);
  RunMark mark{7, 7};
  EXPECT_EQ(read(cursor, history, &mark), Numbers{});
  EXPECT_EQ(mark, (RunMark{0, 0}));
  history.add(1, 100, "done");
  RunCursor again(mark);
  EXPECT_EQ(read(again, history), Numbers{1});
}

TEST(RunCursor, what_ended_while_nobody_asked_is_news_once) {
  for (const std::size_t page : {2u, 3u, 1000u}) {
    History history{{}, page};
    for (std::uint64_t i = 1; i <= 20; ++i) history.add(i, 100 * i, i == 20 ? "running" : "done");
    RunMark mark{12, 1200};
    RunCursor cursor(mark);
    EXPECT_EQ(read(cursor, history, &mark), (Numbers{13, 14, 15, 16, 17, 18, 19})) << page;
    EXPECT_EQ(mark, (RunMark{19, 1900}));
    RunCursor next(mark);
    EXPECT_EQ(read(next, history, &mark), Numbers{}) << page;
  }
}

TEST(RunCursor, a_spool_that_was_restored_is_told_from_when_the_mark_began) {
  History history{{}, 2};
  for (std::uint64_t i = 1; i <= 10; ++i) history.add(i, 100 * i, "done");
  for (std::uint64_t i = 11; i <= 14; ++i)
    history.add(i, 5000 + i, "done");  // numbers that were there before
  RunMark mark{15, 1500};
  bool anew = false;
  RunCursor cursor(mark);
  EXPECT_EQ(read(cursor, history, &mark, &anew), (Numbers{11, 12, 13, 14}));
  EXPECT_TRUE(anew);
  EXPECT_EQ(mark, (RunMark{14, 5014}));
  history.add(15, 6000, "done");
  EXPECT_EQ(read(cursor, history, &mark), Numbers{15});
}

TEST(RunCursor, the_same_number_of_another_spool_is_another_run) {
  History history;
  history.add(5, 9000, "done");
  RunCursor cursor(RunMark{5, 500});
  EXPECT_EQ(read(cursor, history), Numbers{5});
  EXPECT_EQ(read(cursor, history), Numbers{});
}

TEST(RunCursor, a_marked_run_that_is_forgotten_makes_nothing_told_twice) {
  History history;
  RunMark mark{5, 500};
  RunCursor cursor(mark);
  EXPECT_EQ(read(cursor, history, &mark), Numbers{}) << "the whole past is forgotten";
  EXPECT_EQ(mark, (RunMark{0, 500}));
  EXPECT_EQ(read(cursor, history, &mark), Numbers{});
  history.add(6, 600, "done");
  EXPECT_EQ(read(cursor, history, &mark), Numbers{6});
  RunCursor other(RunMark{5, 500});
  EXPECT_EQ(read(other, history), Numbers{6});
}

TEST(RunCursor, too_many_news_are_cut_to_the_newest) {
  History history;
  for (std::uint64_t i = 1; i <= 2500; ++i) history.add(i, 100 + i, "done");
  RunCursor cursor(RunMark{9999, 50});
  std::uint64_t cut = 0;
  std::vector<ToldRun> ended;
  while (ended.empty())
    if (auto news = cursor.take(history.after(cursor.ask_from()))) ended = news->ended, cut = news->cut;
  EXPECT_EQ(ended.size(), RunCursor::kMostNews);
  EXPECT_EQ(ended.back().run, 2500u);
  EXPECT_EQ(cut, 1500u);
}

}  // namespace
}  // namespace tiltfeed::desk
