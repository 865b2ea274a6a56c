#pragma once
/// @file The operators; who adds one adds its row here.

#include <tuple>

#include "lumesh/operators/angle_optimisation.hpp"
#include "lumesh/operators/collapse.hpp"
#include "lumesh/operators/insertion.hpp"
#include "lumesh/operators/reconnection.hpp"
#include "lumesh/operators/smoothing.hpp"

namespace lumesh::operators {

/// Every operator that leaves a valid mesh with its qualities right, so that any other may follow; the tests
/// apply them in random order (tests/fixtures/random_operator.hpp). Not Thinning, which leaves approximate
/// qualities.
using AllOperators =
    std::tuple<EdgeSplit, CentroidInsertion, EdgeCollapse, VertexCollapse, EdgeRemoval, FaceRemoval,
               TetReconnection, VertexSmoothing, VertexOptimisation, VertexSliding, AngleInsertion>;

}  // namespace lumesh::operators
