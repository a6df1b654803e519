#pragma once
// Long-term keys of the two computers: CURVE (elliptic curve 25519), as text of 40 characters (Z85, ZeroMQ RFC 32).
#include <string>
#include <vector>

namespace kt {

struct CurveKey {
  std::string public_key, secret_key;
};

/// A new pair. Throws RunError: ZeroMQ has no CURVE.
CurveKey new_curve_key();

/// Writes a new pair: dir/public.key for others, dir/secret.key for the owner's eyes (mode 0600). Makes the folder.
/// Throws InputError: a key is there already, or the folder cannot be written, or others may write there.
void make_key(const std::string& dir);

/// Reads dir/public.key and dir/secret.key. Throws InputError: not there, not keys, not a pair, a secret that others
/// may read, a folder or file that others may write.
CurveKey read_key(const std::string& dir);

/// Whether the text is a key: 40 characters of Z85.
bool is_curve_key(const std::string& key);

/// A key given as text, or a file with one, which others may not write. Throws InputError.
std::string read_public_key(const std::string& key_or_file, const std::string& what);

/// Public keys that may connect: one a line, # begins a comment; others may not write the file. Throws InputError with
/// the line's number.
std::vector<std::string> read_authorized(const std::string& file);

}  // namespace kt
