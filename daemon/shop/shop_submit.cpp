// A job into the shop's queue: its files by pieces, in one transaction.

#include <cstdlib>

#include "daemon/shop/shop_files.h"
#include "daemon/shop/shop_layout.h"
#include "daemon/shop/shop_orders.h"

namespace tiltfeed::daemon {

namespace {

Result<void> send_files(const ShopAsk& ask, const ShopSubmission& job, const std::vector<ShopFile>& files) {
  for (std::size_t index = 0; index < files.size(); ++index) {
    std::uint64_t piece = 0;
    const Result<ShopFile> sent =
        read_pieces(job.files[index], [&](const std::string& bytes) -> Result<void> {
          const auto kept = ask("INSERT INTO tiltfeed.pieces VALUES ($1, $2, $3, $4)",
                                {job.id, std::uint64_t{index}, piece++, {bytes, true}});
          return kept ? Result<void>() : tl::unexpected<Error>(kept.error());
        });
    if (!sent) return tl::unexpected<Error>(sent.error());
    if (!(*sent == files[index]))
      return fail(Code::kInput, "the file changed while it was read; submit it again");
  }
  return {};
}

/// What the queue knows under this id.
struct KnownJob {
  std::uint64_t number = 0;
  std::string state;
  bool has_files = false;
};

Result<std::optional<KnownJob>> find_in_shop(const ShopAsk& ask, const ShopSubmission& job,
                                             const std::string& sha256) {
  const auto rows = ask(
      "SELECT j.number, j.sha256, j.state, EXISTS (SELECT 1 FROM tiltfeed.pieces p WHERE p.job = j.id) FROM "
      "tiltfeed.jobs j WHERE j.id = $1",
      {job.id});
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->rows.empty()) return std::nullopt;
  const PgRow& row = rows->rows[0];
  if (row[1] != sha256) return fail(Code::kUsage, "the id " + job.id + " is another job's, number " + row[0]);
  return KnownJob{std::strtoull(row[0].c_str(), nullptr, 10), row[2], row[3] == "t"};
}

Result<std::uint64_t> insert_job(const ShopAsk& ask, const ShopSubmission& job, const std::string& needs,
                                 const std::vector<ShopFile>& files) {
  const ShopFile part = job.program ? ShopFile() : files[1];
  const auto row =
      ask("INSERT INTO tiltfeed.jobs (id, name, program, needs, sha256, bytes, part_sha256, part_bytes) "
          "VALUES ($1, $2, "
          "$3, $4, $5, $6, $7, $8) ON CONFLICT (id) DO UPDATE SET needs = $4, bytes = $6, part_sha256 = $7, "
          "part_bytes = "
          "$8 RETURNING number",
          {job.id, job.name, job.program, needs, files[0].sha256, files[0].bytes, part.sha256, part.bytes});
  if (!row) return tl::unexpected<Error>(row.error());
  if (const Result<void> sent = send_files(ask, job, files); !sent)
    return tl::unexpected<Error>(sent.error());
  return std::strtoull(row->rows.at(0).at(0).c_str(), nullptr, 10);
}

/// One that came to nothing for want of its files is for whoever fits.
Result<void> open_again(const ShopAsk& ask, const std::string& id) {
  const auto ticket = ask("UPDATE tiltfeed.shop SET token = token + 1 RETURNING epoch, token", {});
  if (!ticket) return tl::unexpected<Error>(ticket.error());
  const auto opened =
      ask("UPDATE tiltfeed.jobs SET state = 'open', machine = NULL, epoch = $2, token = $3, version = 0, "
          "note = '', changed "
          "= now() WHERE id = $1",
          {id, ticket->rows.at(0).at(0), ticket->rows.at(0).at(1)});
  if (!opened) return tl::unexpected<Error>(opened.error());
  return {};
}

}  // namespace

Result<std::uint64_t> submit_to_shop(const ShopAsk& ask, const ShopSubmission& job) {
  if (!is_uuid(job.id)) return fail(Code::kUsage, "an id is a UUID of lower-case hexadecimal digits");
  const std::string needs = needs_json(job.needs);
  if (needs.size() > kMostShopJson) return fail(Code::kInput, "what the job needs is too long");
  std::vector<ShopFile> files;
  for (const int file : job.files) {
    const Result<ShopFile> read = read_digest(file);
    if (!read) return tl::unexpected<Error>(read.error());
    files.push_back(*read);
  }
  if (files.size() != (job.program ? 1u : 2u)) return fail(Code::kUsage, "a program is one file, a job two");
  const auto known = find_in_shop(ask, job, files[0].sha256);
  if (!known) return tl::unexpected<Error>(known.error());
  // A database that was restored may have the job from its machine, and not the files.
  const std::string state = *known ? (*known)->state : "";
  const bool lacks_files = *known && !(*known)->has_files && (state == "accepted" || state == "spoiled");
  if (*known && !lacks_files) return (*known)->number;
  std::uint64_t number = 0;
  const Result<void> done = in_one_transaction(ask, [&]() -> Result<void> {
    const Result<std::uint64_t> given = insert_job(ask, job, needs, files);
    if (!given) return tl::unexpected<Error>(given.error());
    number = *given;
    if (state == "spoiled")
      if (Result<void> opened = open_again(ask, job.id); !opened) return opened;
    const auto told = ask(kShopNotify, {});
    return told ? Result<void>() : tl::unexpected<Error>(told.error());
  });
  if (!done) return tl::unexpected<Error>(done.error());
  return number;
}

}  // namespace tiltfeed::daemon
