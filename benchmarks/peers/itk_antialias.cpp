/// @file itk::AntiAliasBinaryImageFilter: a level set that keeps the voxels of a binary image on their sides.
///
/// Usage: itk_antialias IN.raw OUT.raw NX NY NZ RMS ITERATIONS
/// IN has unsigned chars 0 and 1, x fastest, voxels of edge 1; OUT float32, > 0 inside. Exit code 1 if a file
/// is wrong.

#include <itkAntiAliasBinaryImageFilter.h>
#include <itkImage.h>

#include <fstream>
#include <iostream>
#include <string>

using Labels = itk::Image<unsigned char, 3>;
using Levels = itk::Image<float, 3>;

int main(int count, char** words) {
  if (count != 8) {
    std::cerr << "usage: itk_antialias IN.raw OUT.raw NX NY NZ RMS ITERATIONS\n";
    return 1;
  }
  Labels::SizeType size;
  for (unsigned axis = 0; axis < 3; ++axis) size[axis] = std::stoul(words[3 + axis]);
  auto labels = Labels::New();
  labels->SetRegions(Labels::RegionType(size));
  labels->Allocate();
  const auto voxels = static_cast<std::streamsize>(labels->GetPixelContainer()->Size());
  std::ifstream in(words[1], std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(labels->GetBufferPointer()), voxels)) return 1;

  auto filter = itk::AntiAliasBinaryImageFilter<Labels, Levels>::New();
  filter->SetInput(labels);
  filter->SetNumberOfWorkUnits(1);
  filter->SetMaximumRMSError(std::stod(words[6]));
  filter->SetNumberOfIterations(std::stoul(words[7]));
  filter->Update();

  std::ofstream out(words[2], std::ios::binary);
  const auto bytes = voxels * static_cast<std::streamsize>(sizeof(float));
  return out.write(reinterpret_cast<const char*>(filter->GetOutput()->GetBufferPointer()), bytes) ? 0 : 1;
}
