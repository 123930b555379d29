// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The Palpate engine: force-deflection curves of a soft body, replayed at 1 kHz and beyond.
//
//   Asset asset = Asset::open(bytes, size, &status);     once; checks everything
//   Contact contact;                                     one per tool
//   Status status = touch(asset, contact, tip_m, out);   every tick: out.force_on_tool_N
//
// Header-only C++17, no heap, no lock, no exception, no RTTI, nothing below it but the compiler's
// own headers. Build with -ffp-contract=off and never with -ffast-math: forces are then equal bit
// for bit across compilers and optimization levels, which opening an asset verifies.
// One Contact must not be used by two threads at once; assets may be shared freely.

#include "asset.hpp"
#include "asset/with_indenter.hpp"
#include "contact/body.hpp"
#include "contact/deform.hpp"
#include "contact/visual.hpp"
#include "series/tick.hpp"
#include "tool/tool.hpp"
