#pragma once
/// @file See stand_in.h.
#include "stand_in.h"
