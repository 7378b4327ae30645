// The files of a claimed job, piece by piece out of the database.

#include "daemon/shop/shop_files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "daemon/files/sha256.h"
#include "daemon/shop/shop_layout.h"

namespace tiltfeed::daemon {

namespace {

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// False: no such text.
bool from_hex(const std::string& text, std::string& bytes) {
  if (text.size() % 2 != 0) return false;
  bytes.resize(text.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const int high = digit_of(text[2 * i]), low = digit_of(text[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    bytes[i] = static_cast<char>(high * 16 + low);
  }
  return true;
}

Result<void> write_all(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      return fail(Code::kIo, std::string("the spool takes no file of the shop: ") + std::strerror(errno));
    done += static_cast<std::size_t>(written);
  }
  return {};
}

}  // namespace

bool is_digest(const std::string& text) {
  constexpr std::size_t kDigits = 64;
  return text.size() == kDigits && text.find_first_not_of("0123456789abcdef") == text.npos;
}

Result<ShopFile> read_pieces(int file, const std::function<Result<void>(const std::string& piece)>& take) {
  struct stat about {};
  if (::fstat(file, &about) != 0) return fail(Code::kIo, std::strerror(errno));
  if (!S_ISREG(about.st_mode)) return fail(Code::kInput, "is no regular file");
  Sha256Sum sum;
  ShopFile read;
  std::string piece;
  for (;;) {
    piece.resize(kShopPieceBytes);
    std::size_t have = 0;
    while (have < piece.size()) {
      const ssize_t got =
          ::pread(file, piece.data() + have, piece.size() - have, static_cast<off_t>(read.bytes + have));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return fail(Code::kIo, std::strerror(errno));
      if (got == 0) break;
      have += static_cast<std::size_t>(got);
    }
    piece.resize(have);
    if (have == 0) break;
    read.bytes += have;
    if (read.bytes > kMostShopBytes)
      return fail(Code::kInput, "is larger than " + std::to_string(kMostShopBytes >> 20U) +
                                    " MiB, which a shop's queue takes; submit it to the machine itself");
    sum.add(piece);
    if (const Result<void> taken = take(piece); !taken) return tl::unexpected<Error>(taken.error());
  }
  if (read.bytes == 0) return fail(Code::kInput, "is empty, there is nothing to send");
  read.sha256 = hex(sum.finish());
  return read;
}

Result<ShopFile> read_digest(int file) {
  return read_pieces(file, [](const std::string&) { return Result<void>(); });
}

Result<void> fetch_pieces(const ShopFile& wanted, const std::function<Result<PgRows>(std::uint64_t)>& piece,
                          int into) {
  Sha256Sum sum;
  std::string bytes;
  std::uint64_t have = 0;
  for (std::uint64_t number = 0; have < wanted.bytes; ++number) {
    const Result<PgRows> rows = piece(number);
    if (!rows) return tl::unexpected<Error>(rows.error());
    const bool one =
        rows->rows.size() == 1 && rows->rows[0].size() == 1 && rows->rows[0][0].size() <= 2 * kShopPieceBytes;
    if (!one || !from_hex(rows->rows[0][0], bytes) || bytes.empty() || have + bytes.size() > wanted.bytes)
      return fail(Code::kInput, "its file in the database is not whole; submit it again");
    sum.add(bytes);
    have += bytes.size();
    if (const Result<void> written = write_all(into, bytes); !written) return written;
  }
  if (hex(sum.finish()) != wanted.sha256)
    return fail(Code::kInput,
                "its file in the database is not the one that was submitted (SHA-256); submit it again");
  if (::lseek(into, 0, SEEK_SET) != 0)
    return fail(Code::kIo, std::string("the spool's file of the shop: ") + std::strerror(errno));
  return {};
}

Result<std::vector<int>> fetch_files(const ShopAsk& ask, const ShopJob& job,
                                     const std::function<int()>& scratch) {
  std::vector<int> files;
  for (std::size_t index = 0; index < job.files.size(); ++index) {
    files.push_back(scratch());
    Result<void> fetched;
    if (files.back() < 0)
      fetched = fail(Code::kIo, std::string("the spool takes no file of the shop: ") + std::strerror(errno));
    else
      fetched = fetch_pieces(
          job.files[index],
          [&](std::uint64_t piece) {
            return ask(kShopPiece, {job.ticket.job, std::uint64_t{index}, piece});
          },
          files.back());
    if (fetched) continue;
    for (const int file : files)
      if (file >= 0) ::close(file);
    return tl::unexpected<Error>(fetched.error());
  }
  return files;
}

Result<void> in_one_transaction(const ShopAsk& ask, const std::function<Result<void>()>& work) {
  if (const auto begun = ask("BEGIN", {}); !begun) return tl::unexpected<Error>(begun.error());
  Result<void> done = work();
  const auto ended = ask(done ? "COMMIT" : "ROLLBACK", {});
  if (done && !ended) return tl::unexpected<Error>(ended.error());
  return done;
}

}  // namespace tiltfeed::daemon
