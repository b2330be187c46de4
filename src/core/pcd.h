// Point Cloud Data files (PCD v0.7): strict reader, deterministic writer.
#pragma once
#include <filesystem>
#include <string>

#include "scslam/core/cloud.h"

namespace scslam {

/// Reads DATA ascii, binary or binary_compressed with at least x y z (FLOAT32/64). Takes intensity ("intensity", "i",
/// "reflectivity"), dt ("t", "time", "dt", "timestamp": seconds or, by TYPE U or I, nanoseconds; relative to the
/// earliest point, unless that lies within a second of 0: then they are relative already) and ring ("ring", "channel",
/// integer) where present; other fields are skipped. POINTS is trusted only up to what the file holds; extra bytes
/// after the last point are allowed (the classic saver leaves some), missing ones are an error. NaN is a value like any
/// other. Never allocates beyond a small multiple of the file's size.
/// @throw inputError "FILE: …" with the header line or the byte.
Cloud readPcd(const std::filesystem::path& file);

/// "FIELDS x y z intensity", float32, DATA binary: byte for byte the header of the classic session. Absent intensity is
/// 0.
std::string encodePcd(const Cloud& cloud);

}  // namespace scslam
