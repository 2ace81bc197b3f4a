//! What a study looks at: the whole image of a scene, or one pixel of it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::render::film::{Film, Pixel};
use crate::render::progressive::{self, Cost, Job, Progress, Stop};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{AnySampler, Sampler, SamplerKind};
use crate::scene::Scene;

/// A scene's image, or a pixel of it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The reconstruction filter.
    pub filter: &'a Filter,
    /// Column and row of the only pixel, if it is one.
    pub pixel: Option<[usize; 2]>,
}

/// Random numbers for so many samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Where they come from.
    pub sampler: SamplerKind,
    /// Their seed.
    pub seed: u64,
    /// Samples of a pixel.
    pub samples: u64,
}

/// Samples that one thread takes of a single pixel at a time, and those after which an interruption is looked at.
const CHUNK: u64 = 256;
const PASS: u64 = 1 << 16;

impl Numbers {
    fn sampler(self, scene: &Scene) -> AnySampler {
        self.sampler.sampler(self.seed, self.samples, scene.film().width as u64)
    }
}

impl View<'_> {
    /// Columns and rows of what is looked at.
    pub fn size(&self) -> [usize; 2] {
        let film = self.scene.film();
        self.pixel.map_or([film.width, film.height], |_| [1, 1])
    }

    /// An image without samples.
    pub fn blank(&self) -> Film {
        let [width, height] = self.size();
        Film::new(width, height)
    }

    /// Takes the samples that `film` lacks. A pixel alone has the samples that it has in the image.
    pub fn raise(
        &self,
        radiance: &dyn Radiance,
        numbers: Numbers,
        film: &mut Film,
        interrupted: &AtomicBool,
        report: &mut dyn FnMut(&Film, Progress),
    ) -> Cost {
        let sampler = numbers.sampler(self.scene);
        let job = Job { scene: self.scene, radiance, filter: self.filter, sampler: &sampler };
        let Some([x, y]) = self.pixel else {
            return progressive::render(&job, film, Stop::Samples(numbers.samples), interrupted, report);
        };
        let (start, samples, width) = (Instant::now(), numbers.samples, self.scene.film().width);
        let chunk = |from: u64, to: u64| {
            let mut sampler = sampler.clone();
            let sample = |at: u64| {
                sampler.begin((y * width + x) as u64, at);
                let (ray, weight) = job.camera_ray(y * width + x, width, &mut sampler);
                radiance.radiance(self.scene, ray, &mut sampler) * weight
            };
            (from..to).map(sample).collect::<Vec<Rgb>>()
        };
        loop {
            let done = film.pixels().first().map_or(samples, Pixel::drawn);
            if done >= samples || interrupted.load(Ordering::Relaxed) {
                break;
            }
            let end = samples.min(done + PASS);
            let starts: Vec<u64> = (done..end).step_by(CHUNK as usize).collect();
            let values: Vec<Vec<Rgb>> = starts.par_iter().map(|&from| chunk(from, end.min(from + CHUNK))).collect();
            values.into_iter().flatten().for_each(|value| film.add(0, 0, value));
            let seconds = start.elapsed().as_secs_f64();
            report(film, Progress { samples: end, seconds, share: end as f64 / samples as f64 });
        }
        Cost { rays: 0, seconds: start.elapsed().as_secs_f64() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::path::PathTracer;
    use crate::scene::builtin::builtin;

    #[test]
    fn a_pixel_alone_has_the_bits_that_it_has_in_the_image() {
        let scene = Scene::new(builtin("cornell-original", &[]).unwrap().unwrap()).unwrap().with_size(9, 6);
        let filter: Filter = "tent".parse().unwrap();
        for &(name, sampler) in SamplerKind::ALL {
            let numbers = Numbers { sampler, seed: 3, samples: 300 };
            let film = |pixel| {
                let view = View { scene: &scene, filter: &filter, pixel };
                let mut film = view.blank();
                view.raise(&PathTracer::default(), numbers, &mut film, &AtomicBool::new(false), &mut |_, _| {});
                film
            };
            assert_eq!(film(None).pixel(4, 5), film(Some([4, 5])).pixel(0, 0), "{name}");
        }
    }
}
