#pragma once
// Files in the shop's database: in pieces, of a size and with a digest that are known before, and all or
// nothing.

#include <functional>
#include <string>
#include <vector>

#include "daemon/shop/pg_connection.h"
#include "daemon/shop/shop_record.h"

namespace tiltfeed::daemon {

/// 64 lower-case hexadecimal digits.
bool is_digest(const std::string& text);

/// Reads the whole file from its beginning, a piece at a time. Errors: kInput: no regular file, empty, larger
/// than kMostShopBytes; kIo; those of `take`.
Result<ShopFile> read_pieces(int file, const std::function<Result<void>(const std::string& piece)>& take);
/// Size and digest alone.
Result<ShopFile> read_digest(int file);

/// `piece` asks for a piece, from 0: one row of hexadecimal digits. What they are together is in `into` then,
/// which stands at its beginning. Errors: kInput: not what was wanted; kIo (the disk); those of `piece`.
Result<void> fetch_pieces(const ShopFile& wanted, const std::function<Result<PgRows>(std::uint64_t)>& piece,
                          int into);

/// The files of a claimed job, as the database has them: open, at their beginning, and checked by their
/// digests. The caller closes them. Errors: kInput: they are not what was claimed; kIo (the spool's disk);
/// those of `ask`.
Result<std::vector<int>> fetch_files(const ShopAsk& ask, const ShopJob& job,
                                     const std::function<int()>& scratch);

/// `work` between BEGIN and COMMIT, or ROLLBACK where it fails.
Result<void> in_one_transaction(const ShopAsk& ask, const std::function<Result<void>()>& work);

}  // namespace tiltfeed::daemon
