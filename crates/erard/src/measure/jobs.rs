//! Independent measurements on as many threads as there are cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use super::{Interrupt, MeasureError};
use crate::simulation::SimulationError;

/// How often the caller is told, and asked whether to go on.
const TELL_EVERY: Duration = Duration::from_millis(20);

/// One measurement; it keeps its own result.
pub(crate) type Job<'a> = Box<dyn FnOnce(Interrupt<'_>) -> Result<(), MeasureError> + Send + 'a>;

/// A measurement that leaves its result in `place`.
pub(crate) fn job<'a, T: Send>(
    place: &'a mut Option<T>,
    measure: impl FnOnce(Interrupt<'_>) -> Result<T, MeasureError> + Send + 'a,
) -> Job<'a> {
    Box::new(move |going| {
        *place = Some(measure(going)?);
        Ok(())
    })
}

/// Does all jobs. `progress` is told the share that is done and ends the work by returning false. The results do not depend on
/// the number of threads: no job sees another's.
///
/// # Errors
/// The first job's, in their order, that failed; [`SimulationError::Interrupted`].
pub(crate) fn do_all(jobs: Vec<Job<'_>>, progress: &mut dyn FnMut(f64) -> bool) -> Result<(), MeasureError> {
    let count = jobs.len();
    let queue: Vec<Mutex<Option<Job<'_>>>> = jobs.into_iter().map(|job| Mutex::new(Some(job))).collect();
    let failures: Mutex<Vec<(usize, MeasureError)>> = Mutex::new(Vec::new());
    let (next, done, stop) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    let going = || !stop.load(Ordering::Relaxed);
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(place) = queue.get(index) else { return };
            let job = place.lock().ok().and_then(|mut place| place.take());
            if let Some(Err(error)) = job.map(|job| job(&going)) {
                stop.store(true, Ordering::Relaxed);
                if let Ok(mut failures) = failures.lock() {
                    failures.push((index, error));
                }
            }
            done.fetch_add(1, Ordering::Relaxed);
        }
    };
    let mut interrupted = false;
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get().min(count));
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            if !progress(done.load(Ordering::Relaxed) as f64 / count as f64) {
                interrupted = true;
                stop.store(true, Ordering::Relaxed);
            }
            std::thread::sleep(TELL_EVERY);
        }
    });
    if interrupted {
        return Err(SimulationError::Interrupted.into());
    }
    let mut failures = failures.into_inner().unwrap_or_default();
    // What was stopped because another failed is not the reason.
    failures.sort_by_key(|(index, error)| (error.is_interruption(), *index));
    failures.into_iter().next().map_or(Ok(()), |(_, error)| Err(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failing(message: &str) -> MeasureError {
        MeasureError::NotAnAction(message.to_owned())
    }

    #[test]
    fn every_job_is_done_and_the_first_failure_told() {
        let mut places = vec![None; 20];
        let jobs = places.iter_mut().enumerate().map(|(i, place)| job(place, move |_| Ok(i * i))).collect();
        do_all(jobs, &mut |_| true).unwrap();
        assert!(places.iter().enumerate().all(|(i, place)| *place == Some(i * i)));

        let (mut a, mut b) = (None::<()>, None::<()>);
        let waiting = job(&mut a, |going| {
            while going() {
                std::thread::yield_now();
            }
            Err(SimulationError::Interrupted.into())
        });
        let error = do_all(vec![waiting, job(&mut b, |_| Err(failing("b")))], &mut |_| true);
        if std::thread::available_parallelism().is_ok_and(|n| n.get() > 1) {
            assert!(error.unwrap_err().to_string().ends_with(": b"));
        }
    }

    #[test]
    fn an_interruption_ends_all() {
        let mut place = None::<()>;
        let waiting = job(&mut place, |going| {
            while going() {
                std::thread::yield_now();
            }
            Err(SimulationError::Interrupted.into())
        });
        assert!(do_all(vec![waiting], &mut |_| false).unwrap_err().is_interruption());
    }
}
